"""Drawing, filters and transforms of OpenCV (a module generated for C++)."""

import cv2
import numpy as np

SCALE = 0.5
SIZE = 3
NAME = "front"

image = np.zeros((60, 80, 3), np.uint8)
cv2.circle(image, (10 * SIZE, 20), SIZE, (255, SIZE, 0), -1)
font = cv2.FONT_HERSHEY_SIMPLEX
cv2.putText(image, f"{NAME}/{SIZE}", (5, 30), font, SCALE, (0, 255, SIZE), 1, cv2.LINE_AA)
cv2.rectangle(image, (SIZE, SIZE), (SIZE + 20, 30), color=(1, 2, SIZE), thickness=SIZE)
turned = cv2.warpAffine(image, cv2.getRotationMatrix2D((40, 30), 45.0 * SCALE, 1.0), (80, 60))
edges = cv2.Canny(image, 100 * SCALE, 200)
kernel = cv2.getStructuringElement(cv2.MORPH_RECT, (SIZE, SIZE))
print(image.sum(), turned.sum(), edges.sum())
print(cv2.GaussianBlur(image, (5, 5), SCALE).sum())
print(cv2.erode(image, kernel, iterations=SIZE).sum())
print(cv2.resize(image, None, fx=SCALE, fy=SCALE).shape, cv2.resize(image, (40 + SIZE, 30)).shape)
print(cv2.inRange(image, (0, 10 * SIZE, 0), (255, 255, 255)).sum())
print(cv2.threshold(image[:, :, 0], 127 * SCALE, 255, cv2.THRESH_BINARY)[0])
print(cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, SIZE])[0])
try:
    cv2.circle(image, (NAME, 1), SIZE, (0, 0, 0))
except cv2.error as error:
    print(str(error).splitlines()[-2:])

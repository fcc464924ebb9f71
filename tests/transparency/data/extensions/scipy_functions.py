"""Rotations, filters, solvers and integrators of SciPy (C, C++, Cython, Fortran)."""

import numpy as np
from scipy import integrate, interpolate, linalg, ndimage, optimize, signal
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

GAIN = 0.5
ORDER = 3

numerator, denominator = signal.butter(ORDER, GAIN / 2)
print(numerator.round(9), signal.lfilter(numerator, denominator, [1, 0, GAIN]).round(9))
print(Rotation.from_euler("xyz", [0.1, GAIN, 0.3]).as_quat().round(9))
print(Rotation.from_quat([0, 0, GAIN, 1.0]).as_euler("zyx", degrees=True).round(9))
print(round(optimize.brentq(lambda x: x * x - GAIN, 0, ORDER), 9))
print(optimize.minimize(lambda x: (x[0] - GAIN) ** 2 + ORDER, [0.0]).fun)
print(optimize.linprog([1, GAIN], bounds=[(0, ORDER), (GAIN, None)]).fun)
print(optimize.least_squares(lambda x: [x[0] - GAIN, x[1] * ORDER], [0.1, 1.0]).x.round(9))
print(integrate.quad(lambda x: GAIN * x, 0, ORDER))
print(integrate.solve_ivp(lambda t, y: -GAIN * y, (0, ORDER), [1.0], t_eval=[0, 1, 2]).y.round(9))
print(interpolate.CubicSpline([0, 1, 2, ORDER], [0, GAIN, 1, 2])(GAIN).round(9))
print(interpolate.interp1d([0, 1, 2], [0, GAIN, 1], kind="linear")(1.5))
print(KDTree([[0, 0], [GAIN, 1], [2, ORDER]]).query([GAIN, 0.9], k=2))
print(ndimage.gaussian_filter(np.eye(4), sigma=GAIN).round(9))
print(linalg.expm([[0, GAIN], [-GAIN, 0]]).round(9))

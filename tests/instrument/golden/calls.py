"""Calls that would lose provenance."""

import json
import math as m
from math import atan2, sin

import numpy as np
import yaml
from numpy import array

turn = sin


def move(x, y):
    angle = atan2(float(y), int(x)) + m.sqrt(2.0) + turn(0.5)
    return max(angle, 0.1), type(angle), self.sin(1.0), str(x), np.array([x, 1.0]) @ array(y)


with open("mission.yaml") as file:
    mission = yaml.safe_load(file)
settings = json.loads(text, parse_float=float)

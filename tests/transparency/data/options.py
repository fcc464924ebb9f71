"""A program with a command line."""

import argparse

parser = argparse.ArgumentParser(prog="options", description=__doc__)
parser.add_argument("--size", type=int, default=7, help="a number (default: %(default)s)")
parser.add_argument("--name", default="nobody", choices=["nobody", "x"])
parser.add_argument("--scale", type=float, default=0.5, metavar="FACTOR")
print(parser.parse_args())

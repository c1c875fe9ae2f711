"""Numba kernels: arrays and floats in, arrays and floats out.

The ground floor of the house. Modules here import only NumPy, Numba with the llvmlite that it
stands on, and each other (a test holds it), in the order orbits → transfer → timetable → rules (a
contract of import-linter).

Units everywhere below: metres, seconds, radians, metres per second. Bodies are indexed, stations
first. Times count from the epoch of the instance.
"""

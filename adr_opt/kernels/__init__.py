"""Numba kernels: arrays and floats in, arrays and floats out.

The ground floor of the house. Modules here import only numpy, numba and each other (an
import-linter contract holds it), in the order orbits → transfer → timetable → rules.

Units everywhere below: metres, seconds, radians, metres per second. Bodies are indexed, the
station first (index 0). Times count from the epoch of the instance.
"""

"""The 13 debris `odrc` of mcrdv, a planner of several chasers with low thrust.

All debris are to be met by chasers that begin at the centroid of all orbits, with least ΔV in all
(github.com/TheoGuyard/mcrdv, 2026). Rules, constants and the estimate of legs are those of its
experiments.
"""

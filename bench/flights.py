"""Refined flights: what plans cost when flown, loops until they hold, errors, whole missions.

    python bench/flights.py circles
    python bench/flights.py clouds [CATALOGUE...]
    python bench/flights.py mean-motion
    python bench/flights.py loop [--spend-savings]
    python bench/flights.py savings
    python bench/flights.py thrust cloud electric-0
    python bench/flights.py errors
    python bench/flights.py target-errors
    python bench/flights.py hold --limit 12
    python bench/flights.py releases CATALOGUE --tows 100
    python bench/flights.py fragments CATALOGUE --limit 60
    python bench/flights.py missed --targets 1000
    python bench/flights.py screened --objects 24000 --days 10

Real catalogues are those of the folder that ADR_OPT_EXTERNAL_DATA names.
"""

import sys

from flight_tables.approaches import missed
from flight_tables.errors import errors, target_errors
from flight_tables.loops import loop, savings, thrust
from flight_tables.missions import fragments, hold, releases
from flight_tables.refined import circles, clouds, mean_motion
from flight_tables.screened import screened
from tables import experiment

if __name__ == "__main__":
    sys.exit(
        experiment(
            __doc__,
            circles,
            clouds,
            mean_motion,
            loop,
            savings,
            thrust,
            errors,
            target_errors,
            hold,
            releases,
            fragments,
            missed,
            screened,
        )
    )

"""Accuracy of legs: closed forms against optimised, published and flown transfers.

python bench/legs.py low-thrust
python bench/legs.py classes
python bench/legs.py thrust-flown --legs 60
python bench/legs.py drift --gtoc9 FOLDER
python bench/legs.py short-drifts [CATALOGUE...]
python bench/legs.py dual-vectors
"""

import sys

from leg_costs.drift import drift, short_drifts
from leg_costs.free_burns import dual_vectors
from leg_costs.low_thrust import low_thrust
from leg_costs.low_thrust_missions import classes, thrust_flown
from tables import experiment

if __name__ == "__main__":
    sys.exit(
        experiment(__doc__, low_thrust, classes, thrust_flown, drift, short_drifts, dual_vectors)
    )

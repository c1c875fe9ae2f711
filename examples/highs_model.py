"""HiGHS solves the exact model from a file: nothing is lost, but only small missions fit.

    python -m adr_opt generate tiny --seed 3 --out tiny.json
    python -m adr_opt matrix tiny.json --out tiny.lp
    python examples/highs_model.py tiny.json tiny.lp

Needs highspy, and pyomo to write the file.
"""

import sys

import highspy
from coming_back import come_back

import adr_opt


def solve(model: str) -> list[int]:
    """The best order; each column move(a_b_c) at 1 goes from node a on to body c, nodes in time."""
    highs = highspy.Highs()
    highs.setOptionValue("output_flag", False)
    highs.readModel(model)
    highs.run()
    columns = zip(highs.getLp().col_names_, highs.getSolution().col_value, strict=True)
    moves = [
        [int(number) for number in name[5:-1].split("_")]
        for name, value in columns
        if name.startswith("move(") and value > 0.5
    ]
    return [body for _, _, body in sorted(moves)]


if __name__ == "__main__":
    come_back("HiGHS", adr_opt.Mission(adr_opt.load(sys.argv[1])), solve(sys.argv[2]))

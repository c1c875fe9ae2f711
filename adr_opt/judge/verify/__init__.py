"""Verification of certificates: an independent program, deliberately simple.

It shares with planners and proofs the connections of the timetable and nothing else, and these it
samples against the physics of `check`: an import contract holds that. The rules of a mission are
read from the instance once more (:mod:`.legs`), and sums are exact (:mod:`.claim`). What walks
collect is shown by a list of labels, which anybody may make; to be read first are its check
(:mod:`.closed`) and the table that tells what need not be followed (:mod:`.completion`).
"""

from __future__ import annotations

from .verdict import Verdict, verify

__all__ = ["Verdict", "verify"]

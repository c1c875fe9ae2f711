"""Verification of certificates: an independent program, plain on purpose.

It shares with planners and proofs the connections of the timetable and nothing else, and these it
samples against the physics of `check`: an import contract holds that. The rules of a mission are
read from the instance once more (:mod:`.legs`), sums are exact (:mod:`.claim`), and what walks
collect is found out by labels (:mod:`.labels`) that look ahead by a table (:mod:`.ahead`).
"""

from __future__ import annotations

from .verdict import Verdict, verify

__all__ = ["Verdict", "verify"]

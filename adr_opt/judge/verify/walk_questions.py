"""Check of a chaser's walks against a claim, from multipliers and neighbourhoods.

*Walks* are what plans are relaxed to. A walk keeps to all rules of its chaser but one: it may come
back to a target that it has forgotten. When it goes from a body i to a body j it goes on
remembering those targets that stand in the neighbourhood of j, and i if that is a target. So every
plan is a walk, whatever the neighbourhoods, and what holds for walks holds for plans.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from fractions import Fraction
from importlib.metadata import entry_points
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...common.packages import load
from ...legs.connection_finder import ConnectionFinder
from ...plan.certificate import ProvenCut
from ...problem.chasers import Chaser
from ...problem.instance import Instance
from .cargo import left_after
from .closed import FINE, ClosedLabels, Question, why_open
from .completion import completion
from .cuts import WORD, tolls_of
from .legs import MOST, Legs, Loss, lost_by
from .lists import ListedLabels, Lists
from .rules import finders_of


class Paying(NamedTuple):
    """Further payments of walks that pay for ΔV, and the worth required of them.

    Attributes
    ----------
    per_s : float
        Payment for each second until the walk ends [m/s].
    worths : sequence of Fraction
        Of the service of each body; nothing where it does not matter.
    least : Fraction
        Worth required of the walk.
    """

    per_s: float
    worths: Sequence[Fraction] = ()
    least: Fraction = Fraction(0)


class WalkAnswer(NamedTuple):
    """The answer.

    Attributes
    ----------
    reached : bool
        Whether there is a walk that collects as much.
    labels, legs : int
        Number of labels needed, or of legs where walks are counted in steps.
    why : str or None
        Why a list of labels does not show that there is none.
    """

    reached: bool
    labels: int = 0
    legs: int = 0
    why: str | None = None


def refuted(
    instance: Instance,
    chasers: Collection[str],
    connecting: ConnectionFinder,
    said: str,
    answer: Callable[[Chaser, ConnectionFinder], WalkAnswer],
) -> tuple[int, int, str | None]:
    """Labels and legs needed to check a claim on walks, and why it does not follow, if so.

    Parameters
    ----------
    instance : Instance
    chasers : collection of str
        Whose walks they are.
    connecting : ConnectionFinder
    said : str
        Message about a walk that contradicts the certificate; {} is the name of a chaser.
    answer : callable
        The answer for one of them and its connections.
    """
    labels, legs = 0, 0
    for chaser, own in finders_of(instance, chasers, connecting):
        found = answer(chaser, own)
        labels, legs = labels + found.labels, legs + found.legs
        if found.why is not None:
            return labels, legs, f"the labels of {chaser.name!r} prove nothing: {found.why}"
        if found.reached:
            walk = said.format(repr(chaser.name))
            return labels, legs, f"{walk}, but the certificate says that none does"
    return labels, legs, None


EXPANDERS = "adr_opt.expanders"
"""Entry-point group of modules that make lists of closed labels; the lists are not trusted."""


def expander() -> Any:
    """The installed module that makes lists.

    Raises
    ------
    InputError
        There is none.
    """
    for entry in entry_points(group=EXPANDERS):
        return load(entry)
    raise InputError("nothing is installed that makes lists of labels; install adr-opt again")


class WalkQuestion(NamedTuple):
    """A question about the walks over some legs, and where they begin."""

    legs: Legs
    question: Question
    starts: ClosedLabels


def walk_question(
    legs: Legs,
    gains: Sequence[Fraction],
    neighbourhoods: npt.NDArray[np.bool_],
    most: Fraction,
    slot_m_s: float,
    cuts: Sequence[ProvenCut] = (),
    paying: Paying | None = None,
    losses: Sequence[Loss] = (),
) -> WalkQuestion:
    """The question whether a walk collects ``most``.

    Parameters
    ----------
    legs : Legs
    gains : sequence of Fraction
        What the service of each body is worth, less its multiplier.
    neighbourhoods : (bodies, bodies) bool
        Whether a walk that comes to a body (row) still remembers another one (column).
    most : Fraction
    slot_m_s : float
        In which ΔV is counted where labels look ahead: how many there are depends on it, and
        nothing else [m/s].
    cuts : sequence of ProvenCut
        What walks pay for at their second services.
    paying : Paying, optional
        Walks pay for ΔV, and count only if they are worth as much; gains are in m/s then.
    losses : sequence of Loss
        Of gains, where prizes fall; none is known to walks that pay, which may collect more then.
    """
    table = completion(legs, gains, slot_m_s, 0.0 if paying is None else 1.0)
    # Exact sums: what is worth something is worth no less in units, and what is asked for no more.
    unit = table.unit / (1 << FINE)
    need = min(max(math.floor(most / unit), -(2**59)), 2**59)
    neighbours = np.zeros(((len(gains) - 1) // WORD + 1, len(gains)), dtype=np.int64)
    for i, j in np.argwhere(neighbourhoods):
        neighbours[j // WORD, i] |= 1 << (j % WORD)
    gain = np.array([max(math.ceil(each / unit), -MOST) for each in gains])
    per_m_s = 0.0 if paying is None else float(1 / unit)
    worth, least, reach = np.zeros_like(gain), 0, table
    if paying is not None and paying.worths:
        reach = completion(legs, paying.worths, slot_m_s)
        size = reach.unit / (1 << FINE)
        worth[:] = [math.ceil(each / size) for each in paying.worths]
        least = min(math.floor(paying.least / size), 2**59)
    question = Question(
        table,
        reach,
        gain,
        need,
        lost_by(losses, legs.pair % legs.terms.bodies, legs.end, unit),
        neighbours,
        tolls_of(cuts, legs.terms.names, unit),
        per_m_s,
        0.0 if paying is None else per_m_s * paying.per_s,
        legs.terms.begin,
        worth,
        least,
    )
    return WalkQuestion(legs, question, _starts(legs, question, losses, unit))


def walks_reach(over: WalkQuestion, lists: Lists | None = None) -> WalkAnswer:
    """Check whether a walk collects the stated amount.

    Parameters
    ----------
    over : WalkQuestion
    lists : Lists, optional
        Where a list of closed labels may be, and is noted.
    """
    legs, question, starts = over
    maker, made, given = expander(), 0, None if lists is None else lists.next()
    if given is None:
        found = maker.expand(legs, question, starts)
        if found.reached:
            return WalkAnswer(True, found.made)
        given, made = ListedLabels(found.labels, None), found.made
    find, rows = given.find(maker.finder(legs, question, given.labels)), [np.empty(0, np.int64)]

    def noted(ends: ClosedLabels) -> npt.NDArray[np.int64]:
        rows.append(find(ends))
        return rows[-1]

    why = why_open(legs, question, given.labels, starts, noted)
    if lists is not None:
        lists.checked.append(given._replace(row=np.concatenate(rows)))
    return WalkAnswer(why is not None, made or given.labels.body.size, why=why)


def _starts(legs: Legs, question: Question, losses: Sequence[Loss], unit: Fraction) -> ClosedLabels:
    """The beginnings of walks.

    A launch onto a target has what it is worth by then.
    Of kits that weigh something there are as many aboard as will be left behind, be it any number.
    """
    terms, cargo, counting = legs.terms, legs.terms.cargo, legs.terms.counting
    layers = cargo.full.size
    body, kits = np.repeat(terms.starts, layers), np.tile(np.arange(layers), terms.starts.size)
    takes = np.where(body != terms.home, cargo.takes[body], 0)
    may = (kits >= takes) & (cargo.heavy | (kits == layers - 1))
    body, kits, takes = body[may], kits[may], takes[may]
    is_launch, left = body != terms.home, terms.begun[kits]
    # Who is launched onto a target has serviced it by then.
    left = np.where(is_launch, left_after(cargo, body, kits, left), left)
    lost = lost_by(losses, body, terms.ready[body], unit)
    labels = ClosedLabels(
        body,
        kits - takes,
        terms.ready[body],
        left,
        np.where(is_launch, question.gain[body] - lost, 0),
        np.where(is_launch, question.worth[body], 0),
        np.where(is_launch, counting.adds[:, body], 0),
        np.zeros((question.neighbourhoods.shape[0], body.size), dtype=np.int64),
        np.where(is_launch, question.cuts.rows[:, body], 0),
    )
    return labels.at(left >= 0.0)

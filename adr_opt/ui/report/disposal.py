"""The page of ``dispose``, for licensing authorities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import UTC, timedelta

from ...analysis.disposal import Debris, Fate, Reentry
from ...analysis.disposal.casualties import PERSON_M2
from ...analysis.disposal.fates import MOST_CASUALTIES
from ...analysis.disposal.reentry import BURN_ERROR, ENTRY_M, HALF_WIDTH_M
from ...common.json_text import loaded
from ...common.wording import counted
from ...problem.instance import Instance
from . import tables
from .assets import asset
from .plain import page, section, table_of
from .text import fixed, number

HOW = {"tow": "towed by", "kit": "kit of", "chaser": "chaser"}

LIFETIMES = (
    "Time until drag brings an object down, by the decay model with the densities of NRLMSIS 2.1 "
    "at constant solar activity: low (F10.7 of 70), the mean of a cycle, and high (200). The rule "
    "is held against the mean. An area over mass of 0.01 m²/kg is assumed where none is stated."
)

ENTRIES = (
    "Flown from the burn in gravity with harmonics up to J4, without air, down to the ground or to "
    f"the perigee. Entry is at {ENTRY_M / 1e3:g} km. The corridor is {2 * HALF_WIDTH_M / 1e3:g} km "
    f"wide; along the track it begins where a burn {BURN_ERROR:.0%} too large enters, and debris "
    "falls some hundreds of kilometres beyond. A burn at an apogee fixes the latitude of the "
    "perigee; its longitude follows from the revolution that is chosen."
)


def disposal_page(instance: Instance, found: Sequence[Fate], debris: Debris) -> str:
    """The HTML of the page.

    Parameters
    ----------
    instance : Instance
    found : sequence of Fate
        As :func:`adr_opt.analysis.disposal.fates` finds them.
    debris : Debris
        What was assumed.
    """
    met = sum(fate.meets for fate in found)
    under = f"{instance.name} · {met} of {counted(len(found), 'disposal')} within all rules"
    aimed = [(fate, fate.reentry) for fate in found if fate.reentry is not None]
    assumed = (
        f"An estimate: {debris.survives:.1%} of a mass reaches the ground in pieces of "
        f"{debris.piece_kg:g} kg and {debris.piece_m2:g} m², a person is {PERSON_M2:g} m², a "
        f"controlled re-entry fails with a chance of {debris.fails:g}, and people are those below "
        f"the orbit by latitude (GeoNames). The limit is {MOST_CASUALTIES:g}. Pieces are those "
        "of a case that NASA studied in 2011, the Upper Atmosphere Research Satellite."
    )
    parts = [
        section("Disposals", "", _orbits(instance, found)),
        section("Lifetimes", LIFETIMES, _lifetimes(found)),
        section("Casualty expectation", assumed, _casualties(found)),
    ]
    if aimed:
        places = _entries(instance, aimed)
        parts.append(section("Controlled re-entries", ENTRIES, _map(aimed) + places))
    return page("Disposal", f"What becomes of {counted(len(found), 'object')}", under, parts)


def _orbits(instance: Instance, found: Sequence[Fate]) -> str:
    columns: list[tables.Column] = [
        ("object", "", lambda fate: fate.name),
        ("how", "", lambda fate: HOW[fate.how] + (fate.how != "chaser") * f" {fate.chaser}"),
        ("mass, kg", "n", lambda fate: _or(fate.mass_kg, 0)),
        ("last burn or release", "", lambda fate: _when(instance, fate.released_s)),
        ("orbit, km", "n", lambda fate: f"{fate.perigee_m / 1e3:.0f} × {fate.apogee_m / 1e3:.0f}"),
        ("inclination, °", "n", lambda fate: fixed(fate.inclination_deg, 2)),
        ("ΔV, m/s", "n", lambda fate: number(fate.delta_v_m_s)),
        ("propellant, kg", "n", lambda fate: _or(fate.propellant_kg, 1)),
        ("left for it, m/s", "n", lambda fate: _or(fate.left_m_s, 1)),
        ("re-entry", "", lambda fate: "controlled" if fate.controlled else "by drag"),
        ("rules", "", lambda fate: "met" if fate.meets else "; ".join(fate.broken)),
    ]
    return table_of(
        "Disposals", columns, ((fate,) for fate in found), lambda fate: "" if fate.meets else "only"
    )


def _lifetimes(found: Sequence[Fate]) -> str:
    columns: list[tables.Column] = [
        ("object", "", lambda fate: fate.name),
        (
            "area over mass, m²/kg",
            "n",
            lambda fate: f"{fate.area_to_mass_m2_kg:g}{' assumed' * fate.area_is_assumed}",
        ),
        *((f"{activity}, years", "n", _years(activity)) for activity in ("low", "mean", "high")),
    ]
    return table_of("Lifetimes", columns, ((fate,) for fate in found))


def _years(activity: str) -> Callable[[Fate], str]:
    return lambda fate: f"{fate.lifetimes_years[activity]:.3g}"


def _casualties(found: Sequence[Fate]) -> str:
    columns: list[tables.Column] = [
        ("object", "", lambda fate: fate.name),
        ("casualty area, m²", "n", lambda fate: _or(fate.casualty_area_m2, 1)),
        ("people hit, expected", "n", lambda fate: _odds(fate.casualties)),
    ]
    return table_of("Casualty expectation", columns, ((fate,) for fate in found))


def _entries(instance: Instance, aimed: Sequence[tuple[Fate, Reentry]]) -> str:
    columns: list[tables.Column] = [
        ("object", "", lambda fate, aim: fate.name),
        ("burn", "", lambda fate, aim: _when(instance, aim.burn_s)),
        ("m/s", "n", lambda fate, aim: number(aim.burn_m_s)),
        ("entry", "", lambda fate, aim: _when(instance, aim.entry_s)),
        ("place", "", lambda fate, aim: _place(aim.entry)),
        ("earliest", "", lambda fate, aim: _place(aim.earliest)),
        ("latest", "", lambda fate, aim: _place(aim.latest)),
    ]
    return table_of("Controlled re-entries", columns, aimed)


def _map(aimed: Sequence[tuple[Fate, Reentry]]) -> str:
    """Tracks of the last half revolution with their corridors, on a map of the Earth."""
    coast = loaded(asset("coast/coastline.json"))
    shapes = []
    for line in coast["lines"]:
        x = y = 0
        points = []
        for east, north in zip(line[::2], line[1::2], strict=True):
            x, y = x + east, y + north
            points.append((y / coast["units"], x / coast["units"]))
        shapes.append(_path(points, "var(--line)", 0.6))
    for _, aim in aimed:
        shapes += [_path(edge, "var(--accent)", 0.5) for edge in (aim.left, aim.right)]
        shapes.append(_path([(row[1], row[2]) for row in aim.track], "var(--accent)", 1.2))
        latitude, longitude = aim.entry
        shapes.append(f'<circle cx="{longitude:.2f}" cy="{-latitude:.2f}" r="2" fill="#c33"/>')
    return (
        '<figure class="drawn"><svg viewBox="-180 -90 360 180" role="img" '
        'aria-label="Ground tracks of controlled re-entries">'
        f"{''.join(shapes)}</svg><figcaption>Ground tracks from the burn on, with corridors; dots "
        "are entries.</figcaption></figure>"
    )


def _path(points: Sequence[tuple[float, float]], colour: str, width: float) -> str:
    """A line through places, broken where it leaves the map."""
    steps, last = [], None
    for latitude, longitude in points:
        joined = last is not None and abs(longitude - last) < 180.0
        steps.append(f"{'L' if joined else 'M'}{longitude:.2f} {-latitude:.2f}")
        last = longitude
    return f'<path d="{"".join(steps)}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def _when(instance: Instance, time_s: float) -> str:
    return f"{(instance.epoch + timedelta(seconds=time_s)).astimezone(UTC):%Y-%m-%d %H:%M:%S}"


def _place(place: tuple[float, float] | None) -> str:
    return "none" if place is None else f"{place[0]:.1f}°, {place[1]:.1f}°"


def _or(value: float | None, digits: int) -> str:
    return "unknown" if value is None else number(value, digits)


def _odds(chance: float | None) -> str:
    return "unknown" if chance is None else f"{chance:.1e}, 1 in {1.0 / max(chance, 1e-30):,.0f}"

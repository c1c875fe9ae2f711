"""The verbs that run as jobs: inputs, options and output files of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from ....analysis.trade.axes import KINDS
from ....analysis.windows import STATIONS
from ....common.constants import DAY_S, HOUR_S
from ....problem.uncertainty import Uncertainty
from ....run.methods import BOUNDS, PLANNERS, names
from ....run.run_options import DEFAULT_BOUND, DEFAULT_BOUND_TIME_LIMIT_S, DEFAULT_TIME_LIMIT_S
from ..forms.options import JobOption, choice, flag, number, text, whole
from ..planning import LONGEST_S
from ..project.points import PLANS

Need = Literal[
    "instance",
    "mission",
    "plan",
    "plans",
    "plan or refined",
    "refined",
    "certificate",
    "catalogue",
    "uncertainty",
]
"""What a verb reads: ``instance`` is that of the draft, ``mission`` the same with targets that are
excluded and without windows that were found for it, ``plans`` are two or more."""


class JobOutput(NamedTuple):
    """A file that a verb makes.

    Attributes
    ----------
    sign : str
        The option that names it.
    file : str
        Its name in the folder of the result; what stands in braces is the value of an option.
    asked_by : str or None
        The flag of the page that asks for it; None if it is always made.
    """

    sign: str
    file: str
    asked_by: str | None = None


@dataclass(frozen=True)
class JobVerb:
    """A verb.

    Attributes
    ----------
    label : str
    needs : tuple of str
    options : tuple of JobOption
    outputs : tuple of JobOutput
    page : str or None
        Which of these files is its page.
    """

    label: str
    needs: tuple[Need, ...]
    options: tuple[JobOption, ...] = ()
    outputs: tuple[JobOutput, ...] = ()
    page: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """The verb as JSON data, for its button and form."""
        return {
            "label": self.label,
            "needs": list(self.needs),
            "options": [option.to_dict() for option in self.options],
        }


def _planners() -> Sequence[str]:
    return names(PLANNERS)


def _bounds() -> Sequence[str]:
    return names(BOUNDS)


def _limit(default: float) -> JobOption:
    return JobOption(
        "time_limit_s", "--time-limit", "Time limit", "number", "s", default, 0.1, LONGEST_S
    )


def _varied(name: str, label: str) -> JobOption:
    words = {kind.name: kind.title for kind in KINDS.values()}
    return JobOption(
        name,
        "--vary",
        label,
        "vary",
        pattern=VARY,
        help=VARIED,
        choices=lambda: list(KINDS),
        words=words,
    )


def _euros(name: str, label: str) -> JobOption:
    return JobOption(f"{name}_cost_eur", f"--{name}-cost", label, "number", "€", None, 0.0, 1e12)


SEED = whole("seed", "Seed", 0, 0, 2**31 - 1)
BOUND = choice("method", "Bound", _bounds, DEFAULT_BOUND)
PLANNER = choice("method", "Method", _planners)
CERTIFICATE = JobOption("certificate", "", "With a certificate", "flag", default=False)

NAMES = r"[^\x00-\x1f\x7f]*"
VARY = r"[a-z-]+=[0-9eE.,:+-]+"
VARIED = "give a range as NAME=LOW:HIGH:STEP, or values as NAME=VALUE,VALUE"

GRAVITIES = ("two-body", "j2", "j3", "j4")
OF_GRAVITY = "highest zonal harmonic; by default that of the instance"
FLIGHTS = ("oem", "opm", "ocm", "czml", "script")
OF_FLIGHTS = "CCSDS messages of states or burns, CZML for Cesium, or a script for GMAT"
OF_UNSURE = "1σ of each leg's; a dropped file of uncertainties stands in place of these five"
OF_BURNS = "free: least ΔV at any times; planned: the plan's own, changed little"
OF_FORCES = "of a refined plan: its own field, or all forces"
OF_ACTIVITY = "sets the density of the atmosphere"
OF_STATIONS = f"one that sees the target suffices; empty: no condition; {', '.join(STATIONS)}"
OF_ERRORS = "with a dropped file of errors"
OF_RULES = "by default that of the mission"
OF_SUN = "least angle from the velocity"
AROUND = JobOption("around", "", "Around objects of the catalogue", "flag", default=False)

SHARE: dict[str, Any] = {"sign": "", "kind": "number", "unit": "%", "least": 0.0, "most": 100.0}
UNSURE = (
    JobOption("spread", label="Spread of ΔV", default=5.0, help=OF_UNSURE, **SHARE),
    JobOption("success", label="Captures that succeed", default=95.0, **SHARE),
    JobOption("tries", "", "Tries at a capture", "number", "", 2, 1, 9, whole=True),
    JobOption("delay", "", "Delay of services, mean", "number", "h", 0.0, 0.0, 1000.0),
    JobOption("slip", "", "Slip of launches, mean", "number", "days", 0.0, 0.0, 1000.0),
)
"""Uncertainties stated by options instead of a file."""


def unsure(given: Mapping[str, Any]) -> Uncertainty:
    """The uncertainties of the options :data:`UNSURE`, with defaults for those not given."""
    stated = {option.name: given.get(option.name, option.default) for option in UNSURE}
    content: dict[str, Any] = {
        "legs": {"delta_v_factor": {"lognormal_sigma": stated["spread"] / 100.0}},
        "capture": {"success": stated["success"] / 100.0, "tries": int(stated["tries"])},
    }
    if stated["delay"]:
        content["service_s"] = {"added": {"mean_s": stated["delay"] * HOUR_S}}
    if stated["slip"]:
        content["launches"] = {"slip_s": {"mean_s": stated["slip"] * DAY_S}}
    return Uncertainty.model_validate(content)


VERBS: dict[str, JobVerb] = {
    "bound": JobVerb(
        "Prove a bound",
        ("instance",),
        (BOUND, _limit(DEFAULT_BOUND_TIME_LIMIT_S), SEED, CERTIFICATE),
        (JobOutput("--certificate", "certificate.json.gz", "certificate"),),
    ),
    "refine": JobVerb(
        "Refine",
        ("plan",),
        (
            choice("gravity", "Gravity", GRAVITIES, help=OF_GRAVITY),
            choice("burns", "Burns", ("free", "planned"), help=OF_BURNS),
        ),
        (JobOutput("--out", "refined.json"),),
    ),
    "solve": JobVerb(
        "Plan until it holds",
        ("instance",),
        (
            PLANNER,
            _limit(DEFAULT_TIME_LIMIT_S),
            SEED,
            whole("rounds", "Most rounds", 10, 1, 100),
            AROUND,
            number("avoid", "Kept away by", "m", "of those; by default 1 km", least=0.0, most=5e3),
            number("avoid_probability", "Or by a probability", "", OF_ERRORS, least=0.0, most=1.0),
        ),
        (JobOutput("--out", "plan.json"), JobOutput("--refined-out", "refined.json")),
    ),
    "fly": JobVerb(
        "Fly",
        ("plan or refined",),
        (
            choice("forces", "Forces", ("j2", "full"), help=OF_FORCES),
            replace(
                whole("samples", "Flights with errors", None, 1, 100_000), help="of a refined plan"
            ),
        ),
    ),
    "check": JobVerb("Check", ("plan",)),
    "screen": JobVerb(
        "Screen",
        ("refined", "catalogue"),
        (
            number("distance", "Reported within", "m", default=5000.0, least=1.0, most=1e6),
            JobOption("messages", "", "Messages (CDM)", "flag", default=False, help=OF_ERRORS),
        ),
        (
            JobOutput("--out", "approaches.csv"),
            JobOutput("--page", "screening.html"),
            JobOutput("--messages", "messages.zip", "messages"),
        ),
        "screening.html",
    ),
    "dispose": JobVerb(
        "Dispose",
        ("plan",),
        (
            number("years", "Longest lifetime", "years", OF_RULES, least=0.0, most=1e4),
            number("uncontrolled", "Controlled above", "kg", OF_RULES, least=0.0, most=1e7),
            number("kit_isp", "Specific impulse of kits", "s", default=220.0, least=1.0, most=1e4),
            number("survives", "Share that reaches the ground", default=0.094, least=0.0, most=1.0),
            number("fails", "Chance that a burn fails", default=0.1, least=0.0, most=1.0),
        ),
        (JobOutput("--out", "disposal.json"), JobOutput("--page", "disposal.html")),
        "disposal.html",
    ),
    "windows": JobVerb(
        "Light and contacts",
        ("mission",),
        (
            JobOption("light", "--light", "In light", "flag", default=True),
            number("sun_angle", "Sun from the approach", "°", OF_SUN, least=0.0, most=179.0),
            text("contact", "Ground stations", help=OF_STATIONS, default="svalbard, troll"),
            number("mask", "Least elevation", "°", default=5.0, least=0.0, most=89.0),
            number("margin", "Margin", "s", "at both ends", default=60.0, least=0.0, most=1e5),
            number("capture", "Time of a capture", "s", default=600.0, least=0.0, most=1e6),
        ),
        (JobOutput("--out", "windows.csv"), JobOutput("--into", "instance.json")),
    ),
    "export": JobVerb(
        "Export flight",
        ("plan or refined",),
        (
            choice("format", "Format", FLIGHTS, "oem", help=OF_FLIGHTS),
            text("chaser", "Chaser", pattern=NAMES, help="which, where there are several"),
        ),
        (JobOutput("--out", "flight.{format}"),),
    ),
    "verify": JobVerb(
        "Verify",
        ("plan", "certificate"),
        (whole("connections", "Connections flown again", 1000, 0, 1_000_000), SEED),
    ),
    "compare": JobVerb(
        "Compare",
        ("plans",),
        (flag("all", "Equal legs, too"),),
        (JobOutput("--page", "comparison.html"),),
        "comparison.html",
    ),
    "tradeoff": JobVerb(
        "Trade off",
        ("instance",),
        (
            _varied("vary", "Vary"),
            _varied("vary_too", "Vary, too"),
            PLANNER,
            _limit(DEFAULT_TIME_LIMIT_S),
            SEED,
            _euros("launch", "Cost of a launch"),
            _euros("kit", "Cost of a kit"),
            _euros("kg", "Cost of a kilogram"),
        ),
        (JobOutput("--page", "tradeoff.html"), JobOutput("--plans", PLANS)),
        "tradeoff.html",
    ),
    "replan": JobVerb(
        "Replan",
        ("plan",),
        (
            JobOption("at_s", "--at", "From", "number", "s", 0.0, 0.0, 1e10, suffix="s"),
            text("lost", "Targets lost", pattern=NAMES),
            text("missed", "Targets missed", pattern=NAMES),
            whole("failed", "Leg that fails", None, 1, 1e6),
            flag("retry", "Try missed ones again"),
            whole("keep", "Legs that stay", 0, 0, 1e6),
            PLANNER,
            _limit(2.0),
        ),
        (JobOutput("--out", "plan.json"), JobOutput("--out-instance", "instance.json")),
    ),
    "rehearse": JobVerb(
        "Rehearse",
        ("plan", "uncertainty"),
        (
            choice("policy", "Policy", ("follow", "skip", "replan", "beam"), "follow"),
            *UNSURE,
            whole("samples", "Rehearsals", 1000, 1, 1e6),
            SEED,
        ),
        (JobOutput("--out", "rehearsal.html"),),
        "rehearsal.html",
    ),
    "worth": JobVerb(
        "Worth of removals",
        ("catalogue",),
        (
            number("years", "Horizon", "years", default=50.0, least=1e-3, most=200.0),
            replace(whole("candidates", "Objects with prizes", 0, 0, 100_000), help="0 for all"),
            choice("activity", "Activity of the Sun", ("low", "mean", "high"), "mean", OF_ACTIVITY),
        ),
        (
            JobOutput("--out", "prizes.csv"),
            JobOutput("--details", "details.csv"),
            JobOutput("--page", "worth.html"),
        ),
        "worth.html",
    ),
    "report": JobVerb(
        "Report",
        ("plan",),
        (flag("fly", "With flown legs"),),
        (JobOutput("--out", "report.html"),),
        "report.html",
    ),
}
"""The verbs by name."""

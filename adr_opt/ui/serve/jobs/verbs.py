"""The verbs that run as jobs: what each needs, its options, and the files that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from ....run.methods import BOUNDS, PLANNERS, names
from ....run.run_options import DEFAULT_BOUND, DEFAULT_BOUND_TIME_LIMIT_S, DEFAULT_TIME_LIMIT_S
from ..forms.options import JobOption
from ..planning import LONGEST_S
from ..project.points import PLANS

Need = Literal[
    "instance", "plan", "plans", "plan or refined", "certificate", "catalogue", "uncertainty"
]
"""What a verb reads: ``instance`` is that of the draft, ``plans`` are two or more."""


class JobOutput(NamedTuple):
    """A file that a verb makes.

    Attributes
    ----------
    sign : str
        The option that names it.
    file : str
        Its name in the folder of the result.
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


def _one_of(*values: str) -> Any:
    return lambda: values


def _planners() -> Sequence[str]:
    return names(PLANNERS)


def _bounds() -> Sequence[str]:
    return names(BOUNDS)


SEED = JobOption("seed", "--seed", "Seed", "number", default=0, least=0, most=2**31 - 1, whole=True)
BOUND = JobOption("method", "--method", "Bound", "choice", default=DEFAULT_BOUND, choices=_bounds)
PLANNER = JobOption("method", "--method", "Method", "choice", choices=_planners)
NAMES = r"[^\x00-\x1f\x7f]*"


def _limit(default: float | None, most: float = LONGEST_S) -> JobOption:
    return JobOption(
        "time_limit_s", "--time-limit", "Time limit", "number", "s", default, 0.1, most
    )


VARY = r"[a-z-]+=[0-9eE.,:+-]+"
VARIED = "give a range as NAME=LOW:HIGH:STEP, or values as NAME=VALUE,VALUE"

ACTIVITY = JobOption(
    "activity",
    "--activity",
    "Activity of the Sun",
    "choice",
    default="mean",
    choices=_one_of("low", "mean", "high"),
    help="on which the density of the air depends",
)


def _euros(name: str, label: str) -> JobOption:
    return JobOption(f"{name}_cost_eur", f"--{name}-cost", label, "number", "€", None, 0.0, 1e12)


VERBS: dict[str, JobVerb] = {
    "bound": JobVerb(
        "Prove a bound",
        ("instance",),
        (
            BOUND,
            _limit(DEFAULT_BOUND_TIME_LIMIT_S),
            SEED,
            JobOption("certificate", "", "With a certificate", "flag", default=False),
        ),
        (JobOutput("--certificate", "certificate.json.gz", "certificate"),),
    ),
    "refine": JobVerb(
        "Refine",
        ("plan",),
        (
            JobOption(
                "gravity",
                "--gravity",
                "Gravity",
                "choice",
                choices=_one_of("two-body", "j2", "j3", "j4"),
                help="zonal harmonics up to this one; by default those of the instance",
            ),
            JobOption(
                "burns",
                "--burns",
                "Burns",
                "choice",
                choices=_one_of("free", "planned"),
                help="free: least ΔV at any times; planned: the plan's own, changed little",
            ),
        ),
        (JobOutput("--out", "refined.json"),),
    ),
    "fly": JobVerb(
        "Fly",
        ("plan or refined",),
        (
            JobOption(
                "forces",
                "--forces",
                "Forces",
                "choice",
                choices=_one_of("j2", "full"),
                help="of a refined plan: its own field, or all forces",
            ),
            JobOption(
                "samples",
                "--samples",
                "Flights with errors",
                "number",
                least=1,
                most=100_000,
                whole=True,
                help="of a refined plan",
            ),
        ),
    ),
    "check": JobVerb("Check", ("plan",)),
    "verify": JobVerb(
        "Verify",
        ("plan", "certificate"),
        (
            JobOption(
                "connections",
                "--connections",
                "Connections flown again",
                "number",
                default=1000,
                least=0,
                most=1_000_000,
                whole=True,
            ),
            SEED,
        ),
    ),
    "compare": JobVerb(
        "Compare",
        ("plans",),
        (JobOption("all", "--all", "Equal legs, too", "flag", default=False),),
        (JobOutput("--page", "comparison.html"),),
        "comparison.html",
    ),
    "tradeoff": JobVerb(
        "Trade off",
        ("instance",),
        (
            JobOption("vary", "--vary", "Vary", "text", pattern=VARY, help=VARIED),
            JobOption("vary_too", "--vary", "Vary, too", "text", pattern=VARY, help=VARIED),
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
            JobOption("lost", "--lost", "Targets lost", "text", pattern=NAMES),
            JobOption("missed", "--missed", "Targets missed", "text", pattern=NAMES),
            JobOption(
                "failed", "--failed", "Leg that fails", "number", least=1, most=1e6, whole=True
            ),
            JobOption("retry", "--retry", "Try missed ones again", "flag", default=False),
            JobOption(
                "keep",
                "--keep",
                "Legs that stay",
                "number",
                default=0,
                least=0,
                most=1e6,
                whole=True,
            ),
            PLANNER,
            _limit(2.0),
        ),
        (JobOutput("--out", "plan.json"), JobOutput("--out-instance", "instance.json")),
    ),
    "rehearse": JobVerb(
        "Rehearse",
        ("plan", "uncertainty"),
        (
            JobOption(
                "policy",
                "--policy",
                "Policy",
                "choice",
                default="follow",
                choices=_one_of("follow", "skip", "replan", "beam"),
            ),
            JobOption(
                "samples",
                "--samples",
                "Rehearsals",
                "number",
                default=1000,
                least=1,
                most=1e6,
                whole=True,
            ),
            SEED,
        ),
        (JobOutput("--out", "rehearsal.html"),),
        "rehearsal.html",
    ),
    "worth": JobVerb(
        "Worth of removals",
        ("catalogue",),
        (
            JobOption("years", "--years", "Horizon", "number", "years", 50.0, 1e-3, 200.0),
            JobOption(
                "candidates",
                "--candidates",
                "Objects with prizes",
                "number",
                default=0,
                least=0,
                most=100_000,
                whole=True,
                help="0 for all",
            ),
            ACTIVITY,
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
        (JobOption("fly", "--fly", "With flown legs", "flag", default=False),),
        (JobOutput("--out", "report.html"),),
        "report.html",
    ),
}
"""The verbs by name."""

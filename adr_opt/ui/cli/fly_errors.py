"""``fly --samples``: options and output of flights with errors."""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING, NamedTuple

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit, say

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ...fly.dispersion import Dispersion, LegDispersion, Quantile
    from ...fly.refine import RefinedPlan
    from ...judge.admit import Admitted
    from ...problem.instance import Instance
    from ...sources.uncertainty import SetsCompared, TargetError
    from .bars import Show

OPTIONS = (
    ("--samples", int, "N", "Also fly a refined plan N times with errors."),
    ("--seed", int, "N", "Seed of the errors; default 0."),
    ("--corrections", int, "N", "Number of pure correction burns after each burn; default 2."),
    ("--burn-magnitude-error", float, "SHARE", "1-sigma error of each burn's size; default 0.005."),
    ("--burn-pointing-error", float, "DEG", "1-sigma error about each axis; default 0.5."),
    ("--navigation-position-error", float, "M", "1-sigma error per axis at departure; default 10."),
    (
        "--navigation-velocity-error",
        float,
        "M_S",
        "1-sigma error per axis at departure; default 0.01.",
    ),
    (
        "--target-errors",
        str,
        "FILE",
        "Position errors of targets: a table, as CSV or JSON, or an OEM.",
    ),
    (
        "--element-sets",
        str,
        "FILE",
        "Element sets of targets at several epochs, compared to estimate errors; repeatable.",
    ),
    (
        "--known-before",
        float,
        "S",
        "Time before a stand-off from which the target's position is known; default one "
        "revolution.",
    ),
    (
        "--out-uncertainty",
        str,
        "FILE",
        "Uncertainty file to write, with the usable share of tanks estimated from the flights.",
    ),
)

SEVERAL = ("--element-sets",)
"""Options that may be repeated."""


class Sampling(NamedTuple):
    """Error options of the command line; None if not given."""

    samples: int | None
    seed: int | None
    corrections: int | None
    burn_magnitude_error: float | None
    burn_pointing_error: float | None
    navigation_position_error: float | None
    navigation_velocity_error: float | None
    target_errors: str | None
    element_sets: tuple[str, ...]
    known_before: float | None
    out_uncertainty: str | None

    def refuse_stray(self) -> None:
        """Raise :class:`InputError` for error options without the options that they need."""
        if self.target_errors is not None and self.element_sets:
            raise InputError("--target-errors and --element-sets exclude each other; give one")
        if self.samples is not None:
            if self.known_before is not None and not self.of_targets:
                raise InputError("--known-before needs --target-errors or --element-sets")
            return
        for (name, *_), value in zip(OPTIONS, self, strict=True):
            if value not in (None, ()):
                raise InputError(f"{name} needs --samples N, the number of flights")

    @property
    def of_targets(self) -> bool:
        """Whether targets may deviate from their planned positions."""
        return self.target_errors is not None or bool(self.element_sets)

    def errors_of_targets(
        self, instance: Instance
    ) -> tuple[Mapping[str, TargetError] | None, SetsCompared | None]:
        """Position errors of targets, and the comparison of element sets if they come from one."""
        from ...sources.uncertainty import compared, read_target_errors

        if self.target_errors is not None:
            return read_target_errors(instance, self.target_errors), None
        if not self.element_sets:
            return None, None
        shown = compared(instance, self.element_sets)
        return shown.errors, shown

    def refuse_unrefined(self, plan_path: str) -> None:
        """Raise :class:`InputError` if flights with errors are requested of an unrefined plan."""
        if self.samples is not None:
            raise InputError(
                f"{plan_path}: flights with errors need a refined plan; make one with 'refine' and "
                "give that"
            )

    def save_uncertainty(
        self, instance: Instance, refined: RefinedPlan, dispersion: Dispersion, quiet: bool
    ) -> None:
        """Write the uncertainty estimated from flights with errors, if requested."""
        if self.out_uncertainty is None:
            return
        from ...fly.dispersion import usable_tank
        from ...problem.uncertainty import Uncertainty

        learnt = Uncertainty(tanks=usable_tank(instance, refined, dispersion))
        learnt.save(self.out_uncertainty)
        say(f"wrote {self.out_uncertainty}", unless=quiet)

    def fly(
        self, admitted: Admitted[RefinedPlan], targets: Mapping[str, TargetError] | None, show: Show
    ) -> Dispersion:
        """Fly the requested number of times, with position errors of targets."""
        from ...fly.dispersion import FlightErrors, sample_flights

        assert self.samples is not None
        said = {
            "burn_magnitude": self.burn_magnitude_error,
            "burn_pointing_deg": self.burn_pointing_error,
            "navigation_position_m": self.navigation_position_error,
            "navigation_velocity_m_s": self.navigation_velocity_error,
        }
        errors = FlightErrors(**{name: value for name, value in said.items() if value is not None})
        said_too = {"seed": self.seed, "corrections": self.corrections}
        return sample_flights(
            admitted.instance,
            admitted,
            self.samples,
            errors,
            report=show,
            targets=targets,
            known_before_s=self.known_before,
            **{name: value for name, value in said_too.items() if value is not None},
        )


error_options = param.together(
    *(
        param.word(name, metavar, text, type=kind, multiple=name in SEVERAL)
        for name, kind, metavar, text in OPTIONS
    )
)
"""The options of flights with errors."""


def tell(dispersion: Dispersion, shown: SetsCompared | None = None) -> None:
    """Print the outcome of flights with errors, and the comparison of element sets."""
    _tell_legs(dispersion)
    if shown is not None:
        emit(_shown(shown))
    for sentence in said(dispersion):
        emit(sentence)


def said(dispersion: Dispersion) -> list[str]:
    """The outcome of flights with errors, in sentences."""
    from ...fly.flight.flights import tank_name

    share = f"{100.0 * dispersion.delta_v_m_s.share:g} %"
    errors = dispersion.errors
    sentences = [
        f"{counted(dispersion.flights, 'flight')} with errors of {errors.burn_magnitude:g} of a "
        f"burn, {errors.burn_pointing_deg:g}°, {errors.navigation_position_m:g} m and "
        f"{errors.navigation_velocity_m_s:g} m/s (1σ): all legs take "
        f"{dispersion.refined_delta_v_m_s:.1f} m/s without errors, and in {share} of the flights "
        f"no more than {_with_interval(dispersion.delta_v_m_s, '.1f')} m/s"
    ]
    if dispersion.uncertain:
        before = dispersion.known_before_s
        lead = "a revolution" if before is None else f"{before:g} s"
        off = [leg.target_off_m.value for leg in dispersion.legs if leg.target_off_m is not None]
        farthest = f"; in {share} they are no more than {max(off) / 1e3:.3g} km off" if off else ""
        sentences.append(
            f"{counted(len(dispersion.uncertain), 'body', 'bodies')} of these legs may be "
            f"elsewhere than planned, known {lead} before the stand-off{farthest}"
        )
    for tank in dispersion.tanks:
        verdict = "holds" if tank.holds else "is not enough"
        sentences.append(
            f"{tank_name(tank.tank, tank.chaser)}, legs {tank.first_leg} to {tank.last_leg}: "
            f"{share} of the flights take no more than "
            f"{_with_interval(tank.delta_v_m_s, '.1f')} of {tank.budget_m_s:g} m/s: {verdict}; "
            f"it breaks in {100.0 * tank.breaks_share:.3g} %"
        )
    sentences.append(
        f"times are kept; {share} of the flights wait no more than "
        f"{_with_interval(dispersion.waits_s, '.0f')} s at stand-offs that they miss by half "
        f"their distance; {100.0 * dispersion.late_share:.3g} % are late for a departure by that"
    )
    linear = dispersion.linearity
    sentences.append(
        f"flown without linearisation, {counted(linear.flights, 'flight')} differ by at most "
        f"{linear.delta_v_m_s:.2g} m/s in all and {linear.standoff_m:.2g} m at a stand-off"
    )
    return sentences


def _shown(compared: SetsCompared) -> str:
    """A sentence on the comparison of element sets."""
    growths = [compared.growths[body] for body in compared.differences]
    middle = [median([growth[at] for growth in growths]) for at in range(4)]
    pairs = sum(map(len, compared.differences.values()))
    said = (
        f"{counted(pairs, 'pair')} of element sets of {counted(len(growths), 'object')}, "
        f"{compared.median_age_days:.1f} days apart in the median, differ (1σ, medians) by "
        f"{middle[0]:.0f} m outward, {middle[2]:.0f} m across, and along the track by "
        f"{middle[1]:.0f} m and a decay of {middle[3]:.2g} m a day"
    )
    if compared.by_median:
        said += f"; {counted(len(compared.by_median), 'target')} of one set take these"
    if compared.by_largest:
        said += (
            f"; {counted(len(compared.by_largest), 'target')} that cannot be compared take the "
            "largest"
        )
    return said


def _with_interval(quantile: Quantile, form: str) -> str:
    low, high = (
        "unknown" if end is None else f"{end:{form}}" for end in (quantile.low, quantile.high)
    )
    return f"{quantile.value:{form}} ({low} to {high})"


def _tell_legs(dispersion: Dispersion) -> None:
    from .tables import emit_legs, whose

    share = f"{100.0 * dispersion.delta_v_m_s.share:g} %"
    off: list[tuple[str, Callable[[LegDispersion], str]]] = []
    if dispersion.uncertain:
        off.append(("target off\nkm", _target_off))
    emit_legs(
        dispersion.legs,
        (
            ("refined\nm/s", lambda leg: f"{leg.refined_delta_v_m_s:.1f}"),
            ("mean\nm/s", lambda leg: f"{leg.mean_delta_v_m_s:.1f}"),
            (f"{share}\nm/s", lambda leg: f"{leg.delta_v_m_s.value:.1f}"),
            ("stand-off\nm", lambda leg: f"{leg.standoff_miss_m.value:.0f}"),
            ("\nm/s", lambda leg: f"{leg.standoff_miss_m_s.value:.2g}"),
            *off,
            ("waits\n%", lambda leg: f"{100.0 * leg.waits_share:.1f}"),
        ),
        whose(dispersion.tanks),
        f"with errors; upper limits of ΔV and stand-off miss in {share} of the flights",
    )


def _target_off(leg: LegDispersion) -> str:
    return "" if leg.target_off_m is None else f"{leg.target_off_m.value / 1e3:.3g}"

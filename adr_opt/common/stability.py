"""Promises about public names and file formats: what is stable, and what is provisional."""

from __future__ import annotations

from typing import Literal

Stability = Literal["stable", "provisional"]


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split())


STABLE = _names("""
    Certificate InputError Instance Matrices MissingExtra Mission Plan RefinedPlan RefinedResult
    Result Timetable Verdict Violation __version__ bound check generate load load_certificate
    load_plan load_refined plan_of refine solve solve_refined verify
""")
"""Names of ``adr_opt`` that keep their arguments and their meaning within 2.x."""

PROVISIONAL = _names("""
    adr_opt.analysis adr_opt.analysis.disposal adr_opt.analysis.scenario adr_opt.analysis.screening
    adr_opt.analysis.windows adr_opt.common.options adr_opt.common.stop
    adr_opt.export.flights adr_opt.export.tables adr_opt.fly.dispersion adr_opt.fly.flight
    adr_opt.fly.forces adr_opt.fly.refine.ephemeris adr_opt.fly.trajectory adr_opt.kernels
    adr_opt.learning adr_opt.learning.environment adr_opt.legs.connections adr_opt.legs.families
    adr_opt.mission.certified adr_opt.mission.order_repair adr_opt.mission.problem
    adr_opt.mission.schedule adr_opt.plan.plane_drift adr_opt.problem.bodies
    adr_opt.problem.chasers adr_opt.problem.disposal adr_opt.problem.given
    adr_opt.problem.given_files
    adr_opt.problem.orbit adr_opt.problem.settings adr_opt.run.methods
    adr_opt.run.reused_timetable adr_opt.sources.catalogue adr_opt.sources.ephemerides
    adr_opt.sources.generator adr_opt.sources.library adr_opt.sources.worth adr_opt.testing
    adr_opt.ui.plot adr_opt.ui.report
""")
"""Documented modules that may change in any version, with a line in the changelog."""

STABLE_FORMATS = _names("""
    adr-opt-instance/3 adr-opt-instance/2 adr-opt-plan/2 adr-opt-refined/1 adr-opt-certificate/1
    adr-opt-uncertainty/1 adr-opt-target-errors/1 adr-opt-functions/1 adr-opt-elements/1
    adr-opt-worth/1 adr-opt-library/1
""")
"""File formats that are read, with the same meaning, by every version 2.x."""

PROVISIONAL_FORMATS = _names("""
    adr-opt-project/1 adr-opt-result/1 adr-opt-study/1 adr-opt-policy/2
""")
"""File formats that a version may replace by others, with a line in the changelog."""


def stability(name: str) -> Stability | None:
    """Stability of a public name, module or file format; None if nothing is promised."""
    if name in STABLE or name in STABLE_FORMATS:
        return "stable"
    return "provisional" if name in PROVISIONAL or name in PROVISIONAL_FORMATS else None

"""Scenarios: decades of campaigns in an environment with decay, break-ups and launches.

`scenario` runs futures with campaigns and without; `scenario_answer` has means over seeds as plain
data, `removals_csv` and `yearly_csv` write tables for other programs. The equations are numbered in
docs/scenarios.md.
"""

from .answer import removals_csv, scenario_answer, yearly_csv
from .futures import Scenario
from .launches import Launch, read_launches
from .settings import AltitudeShells, ScenarioSettings
from .study import scenario

__all__ = [
    "AltitudeShells",
    "Launch",
    "Scenario",
    "ScenarioSettings",
    "read_launches",
    "removals_csv",
    "scenario",
    "scenario_answer",
    "yearly_csv",
]

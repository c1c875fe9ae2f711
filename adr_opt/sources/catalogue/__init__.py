"""Catalogues of real objects: element sets read from files and turned into an instance.

`read` takes TLE and three-line files and OMM as XML, KVN, JSON and CSV, told apart by what is in
them; `to_instance` propagates every object to one epoch by SGP4, filters, and makes the instance.
One module per format: `tle`, `omm_xml`, `omm_kvn`, `omm_json`, `omm_csv`; the last four share
`omm`, which knows the fields.

The elements are *mean* elements of SGP4 in its own frame TEME (true equator, mean equinox), before
and after: an instance made here has the axes of TEME at its epoch, and semi-major axes without the
kilometres by which an osculating orbit wiggles within each revolution.

>>> from adr_opt.sources import catalogue
>>> found = catalogue.read("examples/catalogue/cloud.tle")  # doctest: +SKIP
>>> instance = catalogue.to_instance(found, max_targets=50).instance  # doctest: +SKIP
"""

from .assemble import Imported, MissionOutline, to_instance
from .crew import Crew
from .criticality import criticality
from .demands import Demands
from .filters import Filters
from .propagation import Overview, overview
from .reading import read
from .records import Catalogue, Dropped, ElementSet
from .wishes import Wish, read_wishes

__all__ = [
    "Catalogue",
    "Crew",
    "Demands",
    "Dropped",
    "ElementSet",
    "Filters",
    "Imported",
    "MissionOutline",
    "Overview",
    "Wish",
    "criticality",
    "overview",
    "read",
    "read_wishes",
    "to_instance",
]

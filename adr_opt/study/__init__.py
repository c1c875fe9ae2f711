"""Studies: rows that are functions of their keys, made once, in one file to go on from."""

from .file import check_file
from .run import Run, check_jobs, run
from .study import Place, Study
from .workers import WorkerDied

__all__ = ["Place", "Run", "Study", "WorkerDied", "check_file", "check_jobs", "run"]

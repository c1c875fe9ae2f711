"""Studies: rows computed once from their keys, in one file from which any run can resume."""

from .file import check_file
from .run import Run, check_jobs, run
from .study import Place, Study
from .workers import WorkerDied

__all__ = ["Place", "Run", "Study", "WorkerDied", "check_file", "check_jobs", "run"]

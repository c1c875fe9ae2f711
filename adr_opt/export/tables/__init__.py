"""Matrices of an instance as files for other programs.

One module per format. ``npz`` (NumPy) and ``netcdf`` (xarray) hold ΔV and duration at any ready
times, exactly. ``tsp`` (TSPLIB 95), ``vrp`` (VRPLIB) and ``oplib`` (OPLib) hold one quantity at
one departure, in integers, because that is what those formats can say. ``parquet`` holds the whole
timetable, every connection. ``models`` finds installed packages that write the mission as a
mathematical model.

Nowhere but in ``.oplib`` is service a part of a duration: it goes from ready to arrival. The time
at each body is ``service_s`` in the labelled formats, and SERVICE_TIME_SECTION in a ``.vrp`` of
durations.
"""

from .write import write_matrix, write_timetable

__all__ = ["write_matrix", "write_timetable"]

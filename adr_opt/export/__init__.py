"""The matrices of an instance as files that other programs read.

One module per format: `npz` (NumPy), `netcdf` (xarray), `tsp` (TSPLIB 95), `vrp` (VRPLIB). The
first two hold everything, exactly; the last two hold one quantity at one departure, in integers,
because that is what those formats can say.

Nowhere is service a part of a duration: it goes from ready to arrival. The time at each body is
``service_s`` in the first two, and SERVICE_TIME_SECTION in a ``.vrp`` of durations.
"""

from .write import write_matrix

__all__ = ["write_matrix"]

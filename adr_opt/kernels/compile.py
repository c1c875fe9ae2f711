"""How every kernel is compiled: one place, so that all of them behave alike."""

from numba import njit

# ``nogil``: kernels run in threads, one per core, without fork and without a threading layer.
# ``error_model="numpy"``: a division by zero gives inf, as in NumPy, and saves a branch.
# No ``fastmath``: tables hold +inf for "no transfer", and two machines must agree.
kernel = njit(cache=True, nogil=True, error_model="numpy")

# For the few small kernels that planners call millions of times. A call costs about 100 ns, nearly
# all of it for counting references to the arrays of a table; inlined, they are counted once.
inlined = njit(cache=True, nogil=True, error_model="numpy", forceinline=True)

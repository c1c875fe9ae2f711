"""Judge of refined plans: their states must follow from their burns, and their legs from a plan.

Nothing of :mod:`adr_opt.fly` is known here, and of :mod:`adr_opt.kernels` only what turns mean
elements into a state at the epoch: motion is integrated anew, by another method and in other
variables than those of the refinement.
"""

from .verdict import check_refined

__all__ = ["check_refined"]

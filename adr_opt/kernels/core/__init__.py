"""How kernels are compiled, cached and fed."""

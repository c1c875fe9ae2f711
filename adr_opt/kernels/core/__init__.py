"""Compilation, caching and inputs of kernels."""

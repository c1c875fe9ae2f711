"""The command line: one small module per verb, imported on use.

The modules of the verbs import only click and each other's helpers at the top, and what they work
with inside the function: ``--help`` and wrong calls must not wait for numba.
"""

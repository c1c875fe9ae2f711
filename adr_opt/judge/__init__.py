"""Judges of plans and proofs: ``check`` and ``verify``."""

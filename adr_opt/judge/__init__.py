"""Whether plans and proofs hold: ``check`` and ``verify``."""

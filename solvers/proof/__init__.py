"""Proofs that no plan is better."""

"""Learned policies, for every planner that can use one: files, scores, decoding."""

from .policy import SHIPPED, SHIPPED_QUICK, Policy, load_policy, log_probabilities

__all__ = ["SHIPPED", "SHIPPED_QUICK", "Policy", "load_policy", "log_probabilities"]

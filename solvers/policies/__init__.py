"""Learned policies for planners: files, scores, decoding."""

from .policy import SHIPPED, Policy, load_policy, log_probabilities

__all__ = ["SHIPPED", "Policy", "load_policy", "log_probabilities"]

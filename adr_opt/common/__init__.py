"""Shared basics: errors, files, records, cards, constants, stopping criteria, progress."""

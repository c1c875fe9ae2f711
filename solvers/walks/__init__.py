"""Relaxation behind all bounds: walks in which multipliers limit visits of each target to one.

See docs/model.md section 8.

1. :mod:`solvers.networks.network`: every connection at its own departure, and waiting.
2. :mod:`.walks`: the best walk for given multipliers, by one sweep backwards in time.
3. :mod:`.multipliers`: where to evaluate it next.
4. :mod:`.latest_times`: how late a chaser may be, by a sweep: what guides a search.
5. :mod:`solvers.labels.extension`, :mod:`solvers.labels.label_search`: is there a plan worth so
   much?
"""

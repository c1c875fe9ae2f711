"""The relaxation behind all bounds (MODEL section 8): each target at most once, by multipliers.

1. :mod:`.network`: every connection at its own departure, and waiting.
2. :mod:`.walks`: the best walk for given multipliers, by one sweep backwards in time.
3. :mod:`.multipliers`: where to evaluate it next.
4. :mod:`.completion`: what a sweep knows of every state, as a table for kernels.
5. :mod:`.labels`, :mod:`.routes`: is there a plan worth so much?
"""

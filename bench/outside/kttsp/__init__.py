"""The Keplerian tomato travelling salesperson, ESA's SpOC 4 at GECCO 2026, second challenge.

All targets about the Moon are to be met one after the other by Lambert arcs, as early as possible.
Rules and costs after the text and the utilities that ESA publishes with the instances
(github.com/esa/SpOC4).
"""

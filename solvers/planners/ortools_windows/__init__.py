"""Planner `ortools`: windows of a plan, re-planned by CP-SAT on the exact timetable.

OR-Tools has no routing with costs that depend on the time of travel, and a route planned on costs
frozen at one epoch falls apart when it is timed. So nothing is frozen here. The guarded greedy
plan is the first incumbent; then, again and again, a window of it (one to two days) is thrown
away and planned anew:

1. :mod:`.order` has all schedules of the plan that are worth having. The window begins from the one
   that is best by the window's own measure of time and ΔV: that of least ΔV, which counts in the
   end, would wait for cheap transfers until no time is left.
2. :mod:`.unrolling` unrolls the window into the moves that can be made in it, each by the
   connection that a time value chooses, and flies the rest of the plan from every node in the same
   way, to know what it is worth to arrive there then.
3. :mod:`.prices` bounds what any path of the network is worth and keeps the few hundred edges
   that a better plan is most likely to use. Often this alone proves that there is none.
4. :mod:`.model` lets CP-SAT find the best path that visits no target twice and keeps to the ΔV.
5. The best schedule of the new order, over all connections, says whether it can be flown and gains
   what was promised. :mod:`.fill` appends and inserts what still fits.

Of several chasers one or two are drawn, and a window of each (:mod:`.fleet`). Either may visit
what is in both, and :mod:`.joined` makes one network of the two, so that targets change hands: one
CP-SAT model, priced together, with a path for each chaser.

A window is judged by prize first, then by how early the plan ends and how little ΔV it takes:
most windows gain only slack, which a later window turns into a visit.

What was tried, on the nominal family
-------------------------------------
- *Routing windows*: ``pywrapcp`` with optional visits, a time and a ΔV dimension, a station that
  refuels, arcs at the costs of the middle of the window. Most of its windows broke the rest of the
  plan when they were timed exactly, and plans stayed a visit behind at several times the work.
- *All moves of a window* instead of the most promising ones: from some thousand edges on CP-SAT
  spends its time before it has a first solution. Fewer edges, more windows: 400 did better than
  800 or 1000.
- *Longer windows* have more to gain each, but there are fewer of them, and as many edges cover
  them more thinly; they did slightly worse. So did shorter ones.
- *No limit on how far a path may fall behind the present plan*: growing the networks takes longer
  for the same plans; a limit well below one visit loses plans.
- *Accepting a lower prize* for enough slack gained nothing over accepting equal prize with more
  slack, which most gains are.
- *Windows of two chasers*, with 400 edges each, in every draw or in every second one: 34.5 and 35.5
  visits after 8 s on the first four fields of the family campaign, 35.75 without: they take so long
  that few are planned. With 400 edges for both, in a fifth of the draws: 36.0 against 35.5 without,
  and no difference in 14 s on the next four fields.
- *Time values* of 75, 90, 110 and 130 m/s per h, 10 s on the first five fields: 28.8, 29.0, 29.0
  and 29.2 visits. 110 is what beams choose by, so that one timetable does for both.
- *CP-SAT's settings* (presolve, linearisation, probing, symmetry): no difference beyond noise.

It proves nothing about the mission as a whole, and on thousands of targets the windows see only
those nearby.
"""

from .planner import ortools

__all__ = ["ortools"]

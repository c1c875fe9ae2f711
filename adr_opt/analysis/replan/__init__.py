"""Replanning of what remains of a mission, from the chasers' current states.

`replan` (:mod:`.replanning`) takes the states of all chasers at a time (:mod:`.chaser_states`) with
what went otherwise than planned (:mod:`.deviations`), makes an instance of what remains to be done
(:mod:`.remaining_instance`) from each possible start (:mod:`.starts`), plans it
(:mod:`.remaining_plan`), and compares the plan with the former one (:mod:`.replanned`).
"""

"""Missions as planners see them: rules, prizes, schedules, results."""

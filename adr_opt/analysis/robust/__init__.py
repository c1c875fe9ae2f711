"""Plans that keep their tanks and departures with a chance that is asked for."""

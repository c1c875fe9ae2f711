"""Training of the learned choice of the next leg, see bench/train_next_leg.py."""

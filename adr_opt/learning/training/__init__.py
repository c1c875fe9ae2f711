"""Training of the policy (extra ``[rl]``): what ``train`` runs, and its network for others."""

"""What bounds the objective and plans nothing of its own. None imports another one."""

"""Signs of what no effect on the shelf does."""

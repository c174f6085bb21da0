"""The 1987 paper computed again: its conditions, its figures' counterparts, its claims."""

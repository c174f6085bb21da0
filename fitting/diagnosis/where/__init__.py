"""Where simulation and records part, and what it is that the gap follows."""

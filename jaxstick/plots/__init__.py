"""Figures of what was simulated, one kind a file, and the style they share with those of fits."""

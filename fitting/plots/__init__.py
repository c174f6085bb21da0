"""Figures of a fit, one kind a file."""

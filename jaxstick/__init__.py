"""Stick-slip of a base-excited friction oscillator: physics, simulation and records."""

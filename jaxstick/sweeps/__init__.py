"""Sweeps as the command runs them: planned, computed in chunks that outlive a kill, written as tables."""

"""Diagnosing sealed cases: many at once, taken up again after a kill, each by itself."""

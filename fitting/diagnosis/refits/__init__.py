"""Hypotheses fitted to lanes, and how sure what they find is."""

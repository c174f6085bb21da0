"""From misfits to probabilities and a verdict."""

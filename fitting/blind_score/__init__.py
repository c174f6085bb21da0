"""Scoring diagnoses of sealed cases against the answers: figures with their intervals, tables, pictures."""

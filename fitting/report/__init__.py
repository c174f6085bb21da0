"""The report on a diagnosis: one page of words and pictures, made of findings and cards."""

"""The words by which cases are asked for."""

KINDS = ("single", "none", "pair", "unlisted")
"""One listed effect, none, two listed effects at once, an effect that no catalogue lists."""

TIERS = ("A", "B", "C")
"""The catalogue's formulas; others of the same effects; another friction underneath everything."""

MODES = ("strong", "weak")
"""How strongly effects act: gaps of 3 to 30 times the noise, or about the detection limit."""

FAMILIES = ("development", "calibration", "judging")
"""What cases are for: to build a diagnosis, to set its probabilities, to judge it once."""

SHARES = {"single": 400.0, "none": 300.0, "pair": 120.0, "unlisted": 100.0}
"""How often each kind is made."""

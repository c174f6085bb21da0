"""What rig.toml says of a case: the rig as known, constants as assumed, perhaps the noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from fitting.blind.recipe import Recipe

MASS_ERROR = 0.02
"""In tier C the stated mass is off by up to this share."""

PER_SI = {"mm": 1e3, "um": 1e6, "n": 1.0}
"""Units of columns: what a number in SI is multiplied by."""

ASSUMED = {"A": "A_n", "B": "B_s_per_m", "C": "C_n", "D": "D_n_s_per_m", "k1": "k1_n_per_m"}
SPREAD = {"A": 0.4, "B": 0.4, "C": 0.2, "D": 0.6, "k1": 0.5}
"""Standard deviation of the logarithm of the assumed constants."""


def with_statement(recipe: Recipe, random: np.random.Generator) -> Recipe:
    """The recipe with what its rig.toml says; the rig is stated as it is without the case's effects."""
    p = recipe.physics
    mass = p.mass * (1.0 + (float(random.uniform(-MASS_ERROR, MASS_ERROR)) if recipe.tier == "C" else 0.0))
    ratio = p.damping / (2.0 * np.sqrt(p.stiffness * mass))
    dampings = {
        "damping_n_s_per_m": p.damping,
        "damping_ratio": ratio,
        "log_decrement": 2.0 * np.pi * ratio,
    }
    damping = list(dampings)[random.integers(len(dampings))]
    rig: dict[str, Any] = {
        "mass_kg": mass,
        "stiffness_n_per_m": p.stiffness,
        "drive_stiffness_n_per_m": p.drive_stiffness,
        damping: float(dampings[damping]),
        "drive_damping_n_s_per_m": p.drive_damping,
        "friction_against": "base" if p.against_base else "ground",
    }
    assumed = {
        ASSUMED[name]: getattr(p, name) * float(np.exp(random.normal(0.0, spread)))
        for name, spread in SPREAD.items()
    }
    channels = {"displacement": recipe.displacement, "friction": recipe.friction, "base": recipe.base}
    noise = {
        f"{name}_{channel.unit}": channel.deviation * PER_SI[channel.unit]
        for name, channel in channels.items()
        if channel is not None
    }
    given = random.random() < 0.5
    frequency = recipe.base is None or random.random() < 0.5
    stated = {"rig": rig, "assumed": assumed, "noise": noise if given else {}, "frequency": bool(frequency)}
    return replace(recipe, stated=stated)

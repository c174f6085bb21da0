"""The measuring chain that every case has: sampling, noise, converter."""

from __future__ import annotations

import numpy as np

from fitting.blind.formulation import Floats, Signals
from fitting.blind.noise import coloured
from fitting.blind.recipe import Channel, Recipe
from fitting.blind.truth import OVERSAMPLING, noise_free

INSTANT = np.array([1.0])
AVERAGE = np.array([0.25, 0.5, 0.25])
"""Weights of the readings that make a sample; the second is the mean over a quarter of its interval."""

CHANNELS = ("base", "displacement", "friction")


def sampled(recipe: Recipe, index: int, signals: Signals) -> dict[str, Floats]:
    """The channels as they are sampled, without noise.

    A sharper filter against aliasing would be an effect of its own: at half the sampling rate it rounds the
    kinks of the friction force by several times the noise, in records that are to hold no effect.
    """
    plan = recipe.runs[index]
    weights = AVERAGE if recipe.averaged else INSTANT
    places = plan.settling * OVERSAMPLING - 1 + OVERSAMPLING * np.arange(plan.samples)
    window = places[:, None] + np.arange(len(weights)) - len(weights) // 2
    return {name: getattr(signals, name)[window] @ weights for name in CHANNELS}


def recorded(recipe: Recipe, index: int) -> dict[str, Floats]:
    """The channels of one run as they stand in the record [SI]."""
    clean = sampled(recipe, index, noise_free(recipe, index))
    channels = {"base": recipe.base, "displacement": recipe.displacement, "friction": recipe.friction}
    return {
        name: _converted(clean[name], channel, np.random.default_rng([recipe.seed, index, 2, number]))
        for number, (name, channel) in enumerate(channels.items())
        if channel is not None
    }


def _converted(samples: Floats, channel: Channel, random: np.random.Generator) -> Floats:
    noise = coloured(random, len(samples), channel.correlation, channel.slow)
    return channel.quantum * np.rint((samples + channel.noise * noise) / channel.quantum)

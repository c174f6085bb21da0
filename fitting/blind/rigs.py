"""Random rigs: of other scale, other friction, other runs in every case; nothing here knows of effects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fitting.blind.formulation import angle, between
from fitting.blind.physics import Elements, Physics
from fitting.blind.recipe import Channel, Recipe, RunPlan
from fitting.blind.scales import Scales
from fitting.blind.truth import COARSE, OVERSAMPLING, acting, initial_state, moved

RATES = (80.0, 130.0)
"""Samples in a natural period."""

LOWEST_RATE = 150.0
"""Samples in a second, at least."""

RATIOS = (0.05, 1.2)
"""Drive frequencies over the natural frequency."""

CYCLES = 1.1
"""Drive cycles in the slowest run, at least."""

SLOWEST_SHARE = 0.3
"""The slowest run takes at most this share of all samples, or half of them where there are but two runs."""

RECORDED = 0.8
"""Share of the rigs that record their base. One that rubs on it states it: k1 times the noise of a base
sensor would be many times that of the force."""

ATTEMPTS = 40


@dataclass(frozen=True)
class Size:
    """How much is recorded: runs, and samples of all runs together."""

    runs: int = 6
    samples: int = 8000


def draw_rig(random: np.random.Generator, tier: str, size: Size) -> tuple[Recipe, Scales]:
    """A recipe without effects whose mass sticks and slips, and its scales.

    Rigs that do not are drawn again; raises RuntimeError after ATTEMPTS.
    """
    for _ in range(ATTEMPTS):
        recipe = _candidate(random, tier, size)
        moves = _look(recipe)
        if moves is not None:
            return _with_channels(recipe, moves, random)
    raise RuntimeError(f"none of {ATTEMPTS} rigs shows stick-slip")


def _candidate(random: np.random.Generator, tier: str, size: Size) -> Recipe:
    mass = between(random, 0.05, 50.0)
    natural = between(random, 1.0, 15.0)
    omega = 2.0 * np.pi * natural
    stiffness = mass * omega**2
    damping = 2.0 * between(random, 0.01, 0.08) * mass * omega
    against_base = random.random() < 0.25
    if against_base:
        share = float(random.uniform(0.2, 0.8))
    else:
        share = 1.0 if random.random() < 0.5 else float(random.uniform(0.4, 0.95))
    drive = share * stiffness
    drive_damping = damping * float(random.uniform(0.1, 0.7)) if random.random() < 0.4 else 0.0
    interval = min(1.0 / (natural * random.uniform(*RATES)), 1.0 / LOWEST_RATE)
    interval = max(np.floor(interval * 1e5), 1.0) * 1e-5

    reference = 1e-3 * between(random, 0.2, 20.0)
    pull = (stiffness - drive if against_base else drive) * reference
    force = pull * float(random.uniform(0.15, 0.4))
    A = force * float(random.uniform(0.08, 0.35))
    speed = 2.0 * A / (mass * omega)
    physics = Physics(
        mass=mass,
        stiffness=stiffness,
        drive_stiffness=drive,
        damping=damping,
        drive_damping=drive_damping,
        against_base=float(against_base),
        A=A,
        B=float(random.uniform(1.0, 4.0)) / speed,
        C=force - A,
        D=damping * between(random, 0.01, 1.0),
        k1=stiffness * between(random, 15.0, 100.0),
    )
    recipe = Recipe(
        tier=tier,
        physics=physics,
        elements=Elements(),
        scatter=0.0,
        scatter_time=1.0,
        interval=float(interval),
        runs=_runs(random, natural, reference, interval, size),
        effects=(),
        displacement=_channel(),
        friction=_channel(),
        base=_channel() if random.random() < RECORDED and not against_base else None,
        averaged=tier == "C",
        seed=int(random.integers(2**31)),
        stated={},
    )
    return _with_nuisance(recipe, random) if tier == "C" else recipe


def _runs(
    random: np.random.Generator, natural: float, amplitude: float, interval: float, size: Size
) -> tuple[RunPlan, ...]:
    """Runs from slow to fast, in random order, at two amplitudes or more."""
    per_period = 1.0 / (natural * interval)
    low = max(RATIOS[0], CYCLES * per_period / (max(SLOWEST_SHARE, 1.0 / size.runs) * size.samples))
    edges = np.geomspace(min(low, 0.7 * RATIOS[1]), RATIOS[1], size.runs + 1)
    ratios = np.array([between(random, *edges[i : i + 2]) for i in range(size.runs)])
    needed = np.ceil(CYCLES * per_period / ratios)
    samples = np.maximum(needed, _even_share(needed, size.samples)).astype(int)
    levels = amplitude * random.choice([0.7, 0.85, 1.0, 1.2], size=size.runs)
    levels[0], levels[-1] = amplitude, 0.75 * amplitude
    runs = []
    for ratio, count, level in zip(ratios, samples, levels, strict=True):
        settling = int(max(0.6 * per_period / ratio, 8.0 * per_period))
        runs.append(
            RunPlan(
                frequency=float(np.round(natural * ratio, 5)),
                amplitude=float(level) * (0.7 if ratio > 0.75 else 1.0),
                phase=angle(random),
                samples=int(count),
                settling=settling,
            )
        )
    return tuple(runs[i] for i in random.permutation(size.runs))


def _even_share(needed: np.ndarray, total: int) -> float:
    """The number of samples a run that, with what slow runs need beyond it, makes `total`."""
    low, high = 0.0, float(total)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if np.maximum(needed, middle).sum() > total:
            high = middle
        else:
            low = middle
    return max(low, 64.0)


def _with_nuisance(recipe: Recipe, random: np.random.Generator) -> Recipe:
    """Tier C: the friction is not quite that of any catalogue, and differs from run to run."""
    physics, elements = recipe.physics, recipe.elements
    if random.random() < 0.5:
        breakaway = 0.0 if random.random() < 0.25 else float(random.uniform(0.4, 0.9))
        physics = replace(physics, bristle=1.0, breakaway=breakaway)
    else:
        spread = float(random.uniform(0.05, 0.2))
        limit = 1.0 + spread * np.linspace(-1.0, 1.0, 4)
        elements = Elements((0.25,) * 4, tuple((limit / limit.sum()).tolist()))
    runs = tuple(replace(run, level=float(random.uniform(0.85, 1.15))) for run in recipe.runs)
    return replace(
        recipe,
        physics=physics,
        elements=elements,
        runs=runs,
        scatter=between(random, 0.01, 0.03),
        scatter_time=between(random, 0.1, 3.0) / recipe.runs[0].frequency,
    )


def _channel() -> Channel:
    return Channel(noise=0.0, quantum=0.0, correlation=0.0, slow=0.0, unit="", decimals=0, width=0)


@dataclass(frozen=True)
class _Moves:
    """Half ranges of x and peaks of |v| and |F| by run."""

    strokes: np.ndarray
    speeds: np.ndarray
    forces: np.ndarray


def _look(recipe: Recipe) -> _Moves | None:
    """How the mass moves, or None where a run does not slip or hardly any sticks."""
    strokes, speeds, forces, sticking = [], [], [], 0
    for index, plan in enumerate(recipe.runs):
        run = acting(recipe, index, ())
        readings = (plan.settling + plan.samples) * OVERSAMPLING
        rows = moved(run, initial_state(run), run.start, readings, COARSE)[plan.settling * OVERSAMPLING :]
        slides = float(np.mean(rows[:, 4] > 0.5))
        if slides < 0.08:
            return None
        sticking += slides < 0.9
        strokes.append(np.ptp(rows[:, 0]) / 2.0)
        speeds.append(np.abs(rows[:, 1]).max())
        forces.append(np.abs(rows[:, 2]).max())
    if sticking < max(len(recipe.runs) // 3, 1):
        return None
    return _Moves(np.array(strokes), np.array(speeds), np.array(forces))


def _with_channels(recipe: Recipe, moves: _Moves, random: np.random.Generator) -> tuple[Recipe, Scales]:
    p = recipe.physics
    coarse = recipe.tier == "C"
    stroke, force = float(np.median(moves.strokes)), p.A + p.C
    base = float(np.median([run.amplitude for run in recipe.runs]))
    ring = np.sqrt((p.stiffness + p.k1) * p.mass)
    scales = Scales(
        mass=p.mass,
        stiffness=p.stiffness,
        damping=p.damping,
        period=2.0 * np.pi * float(np.sqrt(p.mass / p.stiffness)),
        stroke=stroke,
        speed=float(np.median(moves.speeds)),
        reach=float(moves.strokes.max()),
        haste=float(moves.speeds.max()),
        base=base,
        force=force,
        stick=force / p.k1,
        weakening=1.0 / p.B,
        ring_damping=float(ring),
        interval=recipe.interval,
        duration=max(run.samples for run in recipe.runs) * recipe.interval,
        lowest=min(run.frequency for run in recipe.runs),
    )
    unit = "mm" if scales.reach > 1e-3 or random.random() < 0.3 else "um"

    def channel(noise: float, peak: float, unit: str) -> Channel:
        factor = {"mm": 1e3, "um": 1e6, "n": 1.0}[unit]
        span = 2.0 * float(random.uniform(2.0, 3.0)) * peak
        quantum = span / 2.0 ** (12 if coarse else 16)
        decimals = int(max(np.ceil(-np.log10(quantum * factor / 20.0)), 0))
        whole = int(max(np.ceil(np.log10(4.0 * peak * factor)), 1))
        return Channel(
            noise=noise,
            quantum=float(quantum),
            correlation=float(random.uniform(0.3, 0.6) if coarse else random.uniform(0.0, 0.12)),
            slow=float(random.uniform(0.05, 0.2)) if coarse else 0.0,
            unit=unit,
            decimals=decimals,
            width=whole + decimals + 2,
        )

    return replace(
        recipe,
        displacement=channel(stroke * between(random, 5e-4, 5e-3), float(moves.strokes.max()), unit),
        friction=channel(force * between(random, 5e-4, 5e-3), float(moves.forces.max()), "n"),
        base=recipe.base
        and channel(base * between(random, 1e-4, 5e-4), max(run.amplitude for run in recipe.runs), unit),
    ), scales

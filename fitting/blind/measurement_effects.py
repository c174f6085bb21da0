"""Effects of the measuring chain, each by the catalogue's formula (A) and by another (B)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fitting.blind.filters import all_pass, highpass_second, lag, late, moving_average, play, resonance
from fitting.blind.formulation import Formulation, RunFacts, Shape, Signals, angle, between
from fitting.blind.physics import Physics
from fitting.blind.scales import Scales

LONGEST = 0.045
"""Delays and lags of channels stay below this [s]."""

PLAYS = np.array([0.4, 0.8, 1.2, 1.6])
"""Widths of the plays of distributed hysteresis, in units of their mean."""


def _lowpass(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    """f + time f' + curvature time^2 f'' = F."""
    root = np.sqrt(shape["curvature"])
    if root < 0.05:
        signals.friction = lag(signals.friction, signals.step, time)
    else:
        frequency = 1.0 / (2.0 * np.pi * time * root)
        signals.friction = resonance(signals.friction, signals.step, frequency, 0.5 / root)


def _curvature(scales: Scales, random: np.random.Generator) -> Shape:
    """One RC stage in four of ten cases, else up to a Butterworth filter of second order."""
    return {"curvature": 0.0 if random.random() < 0.4 else float(random.uniform(0.1, 0.5))}


def _averaged(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    """The mean over the last 2 time: a delay of `time` with rounded edges."""
    signals.friction = moving_average(signals.friction, signals.step, time)


def _late_force(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = late(signals.friction, signals.step, time)


def _all_pass_force(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = all_pass(signals.friction, signals.step, time)


def _gain(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = signals.friction * (1.0 + gain)


def _bent_gain(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    """A gain that is itself a fifth larger at the level of friction."""
    size = (signals.friction / shape["force"]) ** 2
    signals.friction = signals.friction * (1.0 + gain * (1.0 + 0.2 * size))


def _offset(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = signals.friction + force


def _offset_by_run(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    """A zero that was set anew, not quite the same, before every run."""
    signals.friction = signals.friction + force * (1.0 + 0.3 * np.sin(2.4 * run.index + shape["phase"]))


def _drift(signals: Signals, rate: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = signals.friction + rate * signals.time


def _creep(signals: Signals, rate: float, shape: Shape, run: RunFacts) -> None:
    """A drift that calms down within the run."""
    time = 0.7 * run.duration
    signals.friction = signals.friction - rate * time * np.expm1(-np.maximum(signals.time, 0.0) / time)


def _highpass(signals: Signals, corner: float, shape: Shape, run: RunFacts) -> None:
    """First order, nothing lost yet when the run begins."""
    on = signals.time >= 0.0
    entering = np.concatenate(([0.0], signals.friction[on]))
    lost = lag(entering, signals.step, 1.0 / (2.0 * np.pi * corner))
    signals.friction = signals.friction.copy()
    signals.friction[on] -= lost[1:]


def _highpass_second(signals: Signals, corner: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = highpass_second(signals.friction, signals.step, corner)


def _hysteresis(signals: Signals, width: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = play(signals.friction, width)


def _soft_hysteresis(signals: Signals, width: float, shape: Shape, run: RunFacts) -> None:
    """Several plays side by side (Prandtl-Ishlinskii)."""
    signals.friction = np.mean([play(signals.friction, width * part) for part in PLAYS], axis=0)


def _clipped(signals: Signals, cut: float, shape: Shape, run: RunFacts) -> None:
    """Of the force beyond `level` the share `cut` is lost."""
    level = shape["level"]
    beyond = signals.friction - np.clip(signals.friction, -level, level)
    signals.friction = signals.friction - cut * beyond


def _saturated(signals: Signals, cut: float, shape: Shape, run: RunFacts) -> None:
    """The share `cut` passes a soft clip, f/(1 + (f/level)^6)^(1/6)."""
    soft = signals.friction / (1.0 + (signals.friction / shape["level"]) ** 6) ** (1.0 / 6.0)
    signals.friction = signals.friction + cut * (soft - signals.friction)


def _inertia(signals: Signals, mass: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = signals.friction + mass * signals.acceleration


def _late_inertia(signals: Signals, mass: float, shape: Shape, run: RunFacts) -> None:
    """The table follows the mass by a short lag."""
    signals.friction = signals.friction + mass * lag(signals.acceleration, signals.step, shape["time"])


def _crosstalk(signals: Signals, stiffness: float, shape: Shape, run: RunFacts) -> None:
    signals.friction = signals.friction + stiffness * signals.displacement


def _bent_crosstalk(signals: Signals, stiffness: float, shape: Shape, run: RunFacts) -> None:
    more = 1.0 + 0.4 * (signals.displacement / shape["length"]) ** 2
    signals.friction = signals.friction + stiffness * signals.displacement * more


def _table(scales: Scales, random: np.random.Generator) -> Shape:
    return {
        "frequency": max(between(random, 5.0, 25.0) / scales.period, 6.0),
        "damping": between(random, 0.02, 0.3),
    }


def _table_resonance(signals: Signals, share: float, shape: Shape, run: RunFacts) -> None:
    """A share of the force passes a table on springs."""
    passed = resonance(signals.friction, signals.step, shape["frequency"], shape["damping"])
    signals.friction = signals.friction + share * (passed - signals.friction)


def _two_table_resonances(signals: Signals, share: float, shape: Shape, run: RunFacts) -> None:
    """A second mode at 2.7 times the frequency takes a fifth of it."""
    first = resonance(signals.friction, signals.step, shape["frequency"], shape["damping"])
    second = resonance(signals.friction, signals.step, 2.7 * shape["frequency"], shape["damping"])
    signals.friction = signals.friction + share * (0.8 * first + 0.2 * second - signals.friction)


def _long(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    signals.displacement = signals.displacement * (1.0 + gain)


def _bent_long(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    more = 1.0 + 0.2 * (signals.displacement / shape["length"]) ** 2
    signals.displacement = signals.displacement * (1.0 + gain * more)


def _late_displacement(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.displacement = late(signals.displacement, signals.step, time)


def _lagging_displacement(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.displacement = lag(signals.displacement, signals.step, time)


def _base_gain(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    signals.base = signals.base * (1.0 + gain)


def _base_gain_seen(p: Physics, gain: float, shape: Shape, run: RunFacts) -> Physics:
    return replace(p, amplitude=p.amplitude * (1.0 + gain))


def _bent_base_gain(signals: Signals, gain: float, shape: Shape, run: RunFacts) -> None:
    """1 + gain (1 + 0.2 (y/length)^2)."""
    more = 1.0 + 0.2 * (signals.base / shape["length"]) ** 2
    signals.base = signals.base * (1.0 + gain * more)


def _bent_base_gain_seen(p: Physics, gain: float, shape: Shape, run: RunFacts) -> Physics:
    """The cube of a sine is 3/4 of it less 1/4 of its third harmonic."""
    bent = 0.2 * gain * (p.amplitude / shape["length"]) ** 2
    first = 1.0 + gain + 0.75 * bent
    return replace(
        p,
        amplitude=p.amplitude * first,
        third_harmonic=-0.25 * bent / first,
        third_phase=0.0,
    )


def _late_base(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.base = late(signals.base, signals.step, time)


def _late_base_seen(p: Physics, time: float, shape: Shape, run: RunFacts) -> Physics:
    return replace(p, phase=p.phase - p.omega * time)


def _lagging_base(signals: Signals, time: float, shape: Shape, run: RunFacts) -> None:
    signals.base = lag(signals.base, signals.step, time)


def _lagging_base_seen(p: Physics, time: float, shape: Shape, run: RunFacts) -> Physics:
    turn = np.arctan(p.omega * time)
    return replace(p, phase=p.phase - float(turn), amplitude=p.amplitude * float(np.cos(turn)))


def _mains(scales: Scales, random: np.random.Generator) -> Shape:
    return {"frequency": float(random.choice([50.0, 60.0])), "phase": angle(random)}


def _hum(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    """In step with the start of every run."""
    turn = 2.0 * np.pi * shape["frequency"] * signals.time + shape["phase"]
    signals.friction = signals.friction + force * np.sin(turn)


def _rich_hum(signals: Signals, force: float, shape: Shape, run: RunFacts) -> None:
    """With a phase of its own in every run and a weaker third harmonic."""
    turn = 2.0 * np.pi * shape["frequency"] * signals.time + shape["phase"] + 1.7 * run.index
    wave = np.sin(turn) + 0.15 * np.sin(3.0 * turn)
    signals.friction = signals.friction + force * wave


MEASUREMENT = (
    Formulation(
        key="force_lowpass", version="A", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: min(0.3 * s.period, LONGEST), chain=_lowpass,
        shape=_curvature,
    ),
    Formulation(
        key="force_lowpass", version="B", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: min(0.3 * s.period, LONGEST), chain=_averaged,
    ),
    Formulation(
        key="force_delay", version="A", strength="delay", unit="s", signed=False,
        typical=lambda s: 0.005 * s.period, most=lambda s: min(0.1 * s.period, LONGEST), chain=_late_force,
    ),
    Formulation(
        key="force_delay", version="B", strength="time", unit="s", signed=False,
        typical=lambda s: 0.005 * s.period, most=lambda s: min(0.03 * s.period, LONGEST),
        chain=_all_pass_force,
    ),
    Formulation(
        key="force_gain", version="A", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05, chain=_gain,
    ),
    Formulation(
        key="force_gain", version="B", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05,
        shape=lambda s, random: {"force": s.force},
        shape_units={"force": "N"}, chain=_bent_gain,
    ),
    Formulation(
        key="force_offset", version="A", strength="offset", unit="N",
        typical=lambda s: 0.03 * s.force, most=lambda s: 0.5 * s.force, chain=_offset,
    ),
    Formulation(
        key="force_offset", version="B", strength="force", unit="N",
        typical=lambda s: 0.03 * s.force, most=lambda s: 0.5 * s.force,
        shape=lambda s, random: {"phase": angle(random)}, shape_units={"phase": "rad"},
        chain=_offset_by_run,
    ),
    Formulation(
        key="force_drift", version="A", strength="rate", unit="N/s",
        typical=lambda s: 0.03 * s.force / s.duration, most=lambda s: 0.8 * s.force / s.duration,
        chain=_drift,
    ),
    Formulation(
        key="force_drift", version="B", strength="rate", unit="N/s",
        typical=lambda s: 0.03 * s.force / s.duration, most=lambda s: 0.8 * s.force / s.duration,
        chain=_creep,
    ),
    Formulation(
        key="force_highpass", version="A", strength="corner", unit="Hz", signed=False,
        typical=lambda s: 0.03 * s.lowest, most=lambda s: min(3.0 * s.lowest, 4.0), chain=_highpass,
    ),
    Formulation(
        key="force_highpass", version="B", strength="corner", unit="Hz", signed=False,
        typical=lambda s: 0.03 * s.lowest, most=lambda s: min(3.0 * s.lowest, 4.0), chain=_highpass_second,
    ),
    Formulation(
        key="force_hysteresis", version="A", strength="width", unit="N", signed=False,
        typical=lambda s: 0.01 * s.force, most=lambda s: 0.3 * s.force, chain=_hysteresis,
    ),
    Formulation(
        key="force_hysteresis", version="B", strength="width", unit="N", signed=False,
        typical=lambda s: 0.01 * s.force, most=lambda s: 0.3 * s.force, chain=_soft_hysteresis,
    ),
    Formulation(
        key="force_clipping", version="A", strength="cut", unit="1", signed=False,
        typical=lambda s: 0.5, most=lambda s: 1.0,
        shape=lambda s, random: {"level": s.force * float(random.uniform(0.55, 0.9))},
        shape_units={"level": "N"}, chain=_clipped,
    ),
    Formulation(
        key="force_clipping", version="B", strength="cut", unit="1", signed=False,
        typical=lambda s: 0.5, most=lambda s: 1.0,
        shape=lambda s, random: {"level": s.force * float(random.uniform(0.6, 0.95))},
        shape_units={"level": "N"}, chain=_saturated,
    ),
    Formulation(
        key="force_inertia", version="A", strength="mass", unit="kg",
        typical=lambda s: 0.02 * s.mass, most=lambda s: 0.4 * s.mass, chain=_inertia,
    ),
    Formulation(
        key="force_inertia", version="B", strength="mass", unit="kg",
        typical=lambda s: 0.02 * s.mass, most=lambda s: 0.4 * s.mass,
        shape=lambda s, random: {"time": 0.003 * s.period}, shape_units={"time": "s"},
        chain=_late_inertia,
    ),
    Formulation(
        key="force_position_crosstalk", version="A", strength="slope", unit="N/m",
        typical=lambda s: 0.03 * s.force / s.stroke, most=lambda s: 0.5 * s.force / s.stroke,
        chain=_crosstalk,
    ),
    Formulation(
        key="force_position_crosstalk", version="B", strength="stiffness", unit="N/m",
        typical=lambda s: 0.03 * s.force / s.stroke, most=lambda s: 0.5 * s.force / s.stroke,
        shape=lambda s, random: {"length": s.reach}, shape_units={"length": "m"}, chain=_bent_crosstalk,
    ),
    Formulation(
        key="force_table_compliance", version="A", strength="share", unit="1", signed=False,
        typical=lambda s: 0.5, most=lambda s: 1.5, shape=_table, shape_units={"frequency": "Hz"},
        chain=_table_resonance,
    ),
    Formulation(
        key="force_table_compliance", version="B", strength="share", unit="1", signed=False,
        typical=lambda s: 0.5, most=lambda s: 1.5, shape=_table, shape_units={"frequency": "Hz"},
        chain=_two_table_resonances,
    ),
    Formulation(
        key="displacement_gain", version="A", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05, chain=_long,
    ),
    Formulation(
        key="displacement_gain", version="B", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05,
        shape=lambda s, random: {"length": s.reach},
        shape_units={"length": "m"}, chain=_bent_long,
    ),
    Formulation(
        key="displacement_delay", version="A", strength="delay", unit="s", signed=False,
        typical=lambda s: 0.005 * s.period, most=lambda s: min(0.1 * s.period, LONGEST),
        chain=_late_displacement,
    ),
    Formulation(
        key="displacement_delay", version="B", strength="time", unit="s", signed=False,
        typical=lambda s: 0.005 * s.period, most=lambda s: min(0.1 * s.period, LONGEST),
        chain=_lagging_displacement,
    ),
    Formulation(
        key="base_gain", version="A", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05, chain=_base_gain,
        drive=_base_gain_seen,
    ),
    Formulation(
        key="base_gain", version="B", strength="gain", unit="1",
        typical=lambda s: 0.06, most=lambda s: 0.3, least=lambda s: 0.05,
        shape=lambda s, random: {"length": 1.5 * s.base},
        shape_units={"length": "m"}, chain=_bent_base_gain, drive=_bent_base_gain_seen,
    ),
    Formulation(
        key="base_delay", version="A", strength="delay", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: min(0.1 * s.period, LONGEST),
        least=lambda s: s.damping / s.stiffness, chain=_late_base,
        drive=_late_base_seen,
    ),
    Formulation(
        key="base_delay", version="B", strength="time", unit="s", signed=False,
        typical=lambda s: 0.01 * s.period, most=lambda s: min(0.1 * s.period, LONGEST),
        least=lambda s: s.damping / s.stiffness, chain=_lagging_base,
        drive=_lagging_base_seen,
    ),
    Formulation(
        key="mains_hum", version="A", strength="force", unit="N", signed=False,
        typical=lambda s: 0.01 * s.force, most=lambda s: 0.4 * s.force, shape=_mains,
        shape_units={"cosine": "N", "sine": "N", "frequency": "Hz"}, chain=_hum,
        parameters=lambda force, shape: {
            "cosine": force * float(np.sin(shape["phase"])),
            "sine": force * float(np.cos(shape["phase"])),
            "frequency": shape["frequency"],
        },
    ),
    Formulation(
        key="mains_hum", version="B", strength="force", unit="N", signed=False,
        typical=lambda s: 0.01 * s.force, most=lambda s: 0.4 * s.force, shape=_mains,
        shape_units={"frequency": "Hz", "phase": "rad"}, chain=_rich_hum,
    ),
)  # fmt: skip
"""Both forms of every effect of the measuring chain."""

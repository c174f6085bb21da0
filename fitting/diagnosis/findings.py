"""What a diagnosis finds, as plain data: figures and words are made of it elsewhere."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from fitting.correction import Correction
from fitting.diagnosis.accounts import Account
from fitting.result import Constant
from jaxstick.effect import Card

Verdict = Literal["none", "effect", "several", "ambiguous", "unlisted"]
Shares = Mapping[str, float]

TELLING = 3.3
"""Explanations that lie so many standard deviations apart are taken for one another in one of twenty cases:
where chance moves a record by more than half of that, 1.65."""
MOST_TIMES = 20
"""Nobody records a run so many times as long as the others."""


@dataclasses.dataclass(frozen=True)
class Where:
    """Shares of the excess of the residuals over their noise, each group adding up to one.

    channel: displacement, friction; phase: stick, breakaway, slip, arrest; direction: forward, backward; run:
    by file; harmonic: order of the drive's frequency, and "rest"; time: tenths of a run; side: mechanics,
    friction, measurement. `excess` is the excess itself, chi-square per degree of freedom less one, and
    `significance` how many standard deviations of block sums it lies above zero.
    """

    channel: Shares
    phase: Shares
    direction: Shares
    run: Shares
    harmonic: Shares
    time: Shares
    side: Shares
    excess: float
    significance: float


@dataclasses.dataclass(frozen=True)
class ResidualForce:
    """The force that the fitted nominal model lacks, along every fitted run: one entry a sample.

    force [N] that the equation of motion asks for beyond the model's, displacement [m], sliding velocity
    [m/s], time [s], the number of the run, and whether the mass was at rest. `sketch` are the terms that a
    sparse regression finds in it, term by coefficient in newtons at the size of the motion, largest first.
    """

    force: np.ndarray
    displacement: np.ndarray
    slide_rate: np.ndarray
    time: np.ndarray
    run: np.ndarray
    at_rest: np.ndarray
    sketch: Mapping[str, float]


@dataclasses.dataclass(frozen=True)
class Patterns:
    """What the records lack on one side: the excess (chi-square per degree of freedom less one), how many
    standard deviations that lies above zero, and how many segments fit far worse and are no part of either;
    by pattern the share of the excess that a force which follows it foretells, the largest first (shares
    overlap); the frequency of what oscillates apart from the drive [Hz]."""

    excess: float
    significance: float
    apart: int
    shares: Mapping[str, float]
    beat: float | None


@dataclasses.dataclass(frozen=True)
class Parameter:
    """An effect's parameter with its 95 % interval, in its own unit."""

    name: str
    value: float
    low: float | None
    high: float | None
    unit: str


@dataclasses.dataclass(frozen=True)
class Candidate:
    """One effect (or several together) as an explanation.

    keys: the effects; score: the fall of chi-square that the linearised model promises; misfit: chi-square
    per degree of freedom after the refit on the runs that were fitted; closed: the share of the reducible gap
    that it closes there; detection_limit: the strength [own unit] that these records would show in nine of
    ten cases.
    """

    keys: tuple[str, ...]
    score: float
    misfit: float
    closed: float
    probability: float
    parameters: tuple[Parameter, ...]
    detection_limit: float | None


@dataclasses.dataclass(frozen=True)
class Limit:
    """What these records could have shown of one strength of an effect in its usual shape.

    value: the strength [unit] that nine of ten such records would show, were it all that acts; infinite where
    that is more than it can be. `likest` is the effect whose trace in these records is the most like this
    one's, `cosine` that between the two (1: cannot be told apart); None where it leaves no trace.
    """

    effect: str
    strength: str
    value: float
    unit: str
    likest: str | None
    cosine: float | None


@dataclasses.dataclass(frozen=True)
class Likeness:
    """How alike two effects are in these records: cosine of what they leave after everything free is fitted
    (1: cannot be told apart), and the excess of the one beyond the other after refits, in standard
    deviations of block sums."""

    one: str
    other: str
    cosine: float
    separation: float


@dataclasses.dataclass(frozen=True)
class Closure:
    """The gap on runs or segments that took no part in choosing or fitting, in standard deviations of noise,
    what does not repeat itself from cycle to cycle included.

    before: the fitted nominal model; after: with the named effects; floor: what noise alone leaves; assumed:
    the assumed constants; closed = (before - after)/(before - floor) with its 95 % interval; placebo: the
    same share for an effect of no meaning; wrong: for the best effect that the records tell from those named,
    which is `wrong_keys`, None for no such; gain: the mean logarithm of how many times less a segment costs
    with the named effects, which few segments do not decide; steadier: the logarithm of how much likelier
    they make the levels of friction from segment to segment, negative where these are less likely with them;
    rival: the same of what comes nearest to the named effects and shares one with them, None for no such;
    significance: by how many standard deviations the gap before stands above the floor, counted by segments.
    """

    before: float
    after: float
    floor: float
    assumed: float | None
    closed: float
    interval: tuple[float, float]
    placebo: float | None
    wrong: float | None
    held_out: tuple[str, ...]
    by_segments: bool
    gain: float = 0.0
    steadier: float = 0.0
    rival: float | None = None
    significance: float = math.inf
    wrong_keys: tuple[str, ...] = ()


class Plan(NamedTuple):
    """A run that might be recorded: frequency [Hz] and amplitude of the base [m] or, where a force drives the
    rig, of that [N]."""

    frequency: float
    amplitude: float
    by_force: bool


class Proposal(NamedTuple):
    """A run that would tell two explanations apart, how many times as long as the recorded ones it is to be,
    and by how many standard deviations they would then lie apart, in all records together; how far they do
    without it."""

    plan: Plan
    times: int
    separation: float
    so_far: float

    @property
    def tells(self) -> bool:
        """Whether it would tell them apart, and can be recorded."""
        return self.separation >= TELLING and self.times <= MOST_TIMES


@dataclasses.dataclass(frozen=True)
class Trace:
    """One run for pictures: what was measured, and the model before and after, piecewise with free starts.

    Arrays over samples; friction is None where it was not recorded. The noise is that of the channels.
    """

    file: str
    held_out: bool
    time: np.ndarray
    base: np.ndarray
    slide_rate: np.ndarray
    displacement: np.ndarray
    friction: np.ndarray | None
    before_displacement: np.ndarray
    before_friction: np.ndarray
    after_displacement: np.ndarray
    after_friction: np.ndarray
    displacement_noise: float
    friction_noise: float | None


@dataclasses.dataclass(frozen=True)
class Yardstick:
    """What misfits were judged against: the nominal model's own, the one that no model gets below, the
    degrees of freedom, by how much scores vary more from segment to segment than white noise says, and
    whether friction scatters; the accounts of all explanations, what looks like an effect in these records,
    and what does so in part."""

    nominal: float
    floor: float
    samples: float
    inflation: float
    scatters: bool = False
    accounts: tuple[Account, ...] = ()
    aliases: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)
    collinear: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """The whole diagnosis of a data set.

    `named` are the keys of the cause, or of what cannot be told apart, the likeliest first; `probabilities`
    of "none", "unlisted" and every effect add up to one. `candidates` are sorted by probability. `cards` are
    those of all effects of the shelf. `notes` say in sentences what weakens the verdict (channels that are
    missing, segments that were lost, limits of detection). `closed_alone`: the share of the reducible gap
    that a named effect closes without the other named ones, on what took no part; empty where nobody worked
    it out. `correction` is the model with the named effects, as fitted to everything there is; None where
    nothing is named. `limits`: what these records could have shown of every effect of the shelf. `others` and
    `others_before` are what was free within its tolerance besides the constants (rig.mass and the like), with
    and without the named effects. `yardstick`: what the candidates' misfits were judged against. `next_run`:
    the run that would tell apart what the verdict leaves open; None where that is nothing that a run could.
    `follows`: what the gap follows on each side; empty where there is none.
    """

    verdict: Verdict
    named: tuple[str, ...]
    probabilities: Shares
    sentence: str
    where: Where
    residual_force: ResidualForce
    candidates: tuple[Candidate, ...]
    likeness: tuple[Likeness, ...]
    closure: Closure
    effects: Mapping[str, tuple[Parameter, ...]]
    constants: tuple[Constant, ...]
    constants_before: tuple[Constant, ...]
    traces: tuple[Trace, ...]
    cards: Mapping[str, Card]
    next_experiment: str | None
    notes: tuple[str, ...]
    steps: tuple[str, ...]
    sha256: str | None
    settings: Mapping[str, Any]
    seconds: float
    yardstick: Yardstick
    closed_alone: Shares = dataclasses.field(default_factory=dict)
    correction: Correction | None = None
    limits: tuple[Limit, ...] = ()
    others: tuple[Constant, ...] = ()
    others_before: tuple[Constant, ...] = ()
    next_run: Proposal | None = None
    follows: Mapping[str, Patterns] = dataclasses.field(default_factory=dict)

"""What can be read off a run without simulating it: smoothed motion, friction force, noise."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import make_lsq_spline
from scipy.signal import savgol_coeffs, savgol_filter

from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.noise import estimate_noise
from jaxstick.record import KnownRig, Noise, Run

Samples = np.ndarray
ORDERS = 7
LEAST_CYCLES = 0.5
"""Of a period that is longer, too little is seen to tell one."""
AHEAD = 48
"""Samples after the end of a run: a base that is read late is to be known there."""
DEGREE, PIECE = 5, 8
"""Degree of the splines that smooth a base, and how many samples a piece has at least."""
NOISE_EXCESS, EXACT = 1.1, 1e-6
"""A base is met where no more than so many times its noise is left, or than this share of its range;"""
WHITE_EXCESS, WHITE = 1.5, 0.2
"""or so many times where neighbouring samples of what is left are less correlated than this: the noise of a
short record is known to a tenth at best."""
RINGS = 0.1
"""A mass that moves no faster than this share of its top speed, or 4 of its standard deviations, may ring in
stick;"""
FAST = 0.3
"""above this one it surely slides,"""
ALL_BUT = 0.7
"""and no force below this share of the typical one there is that of sliding."""
SMOOTH = 5, 2
"""Samples and order of the polynomials that smooth the recorded friction force."""


@dataclasses.dataclass(frozen=True)
class Signals:
    """One run's samples (SI), the velocity and friction force found from them, and their standard deviations.

    `base` and `force` are the excitation at the samples (zero where the run has none); `ahead` is the base at
    `AHEAD` more samples after the last, where it is known to go on as before, else empty. `slide` and
    `slide_rate` are how far and how fast the mass slides over its guide, which the base may carry. `friction`
    is the recorded friction force or, without that channel, m x'' + c x' + K x - k_d y - c_d y' - u. `rest`
    is for how long the contact has held since the mass slid last [s], `impulse` the integral of the friction
    force from the beginning of the run [N s], `impulse_sum` the integral of that [N s^2], `slid` the sense in
    which the mass slid last (1, -1, or 0 where it has not yet), `recorded` the recorded friction force
    smoothed over a few samples, not a number without that channel.
    """

    run: Run
    base: Samples
    ahead: Samples
    force: Samples
    velocity: Samples
    slide: Samples
    slide_rate: Samples
    friction: Samples
    displacement_noise: float
    friction_noise: float | None
    base_noise: float
    velocity_deviation: float
    friction_deviation: float
    rest: Samples
    impulse: Samples
    impulse_sum: Samples
    slid: Samples
    recorded: Samples

    def redrawn(self, random: np.random.Generator) -> Signals:
        """The same signals with another draw of the base's noise, read off as the record itself was."""
        if self.base_noise == 0:
            return self
        noise = self.base_noise * random.standard_normal(len(self.base))
        base, ahead = _smoothed(self.run.time, self.base + noise)
        return dataclasses.replace(self, base=base, ahead=ahead)


def read_signals(run: Run, noise: Noise) -> Signals:
    """The signals of a run whose channels are that noisy; a level that is not given is estimated from the
    run's own samples."""
    dt = run.interval
    displacement_noise = noise.displacement or estimate_noise(run.displacement)
    friction_noise = None
    if run.friction is not None:
        friction_noise = noise.friction or estimate_noise(run.friction)
    base_noise = 0.0 if run.base is None else noise.base or estimate_noise(run.base)
    base, ahead = base_motion(run, run.time)
    force = np.zeros_like(base) if run.force is None else run.force
    window = _window(natural_period(run.rig) or 100 * dt, dt, len(run.time))
    velocity = np.asarray(savgol_filter(run.displacement, window, 2, deriv=1, delta=dt))
    slide, slide_rate = run.displacement, velocity
    if run.rig.friction_against == "base":
        slide = slide - base
        slide_rate = slide_rate - np.asarray(savgol_filter(base, window, 2, deriv=1, delta=dt))
    velocity_deviation = displacement_noise * math.sqrt(
        np.sum(savgol_coeffs(window, 2, deriv=1, delta=dt) ** 2)
    )
    if run.friction is not None and friction_noise is not None:
        friction, friction_deviation = run.friction, friction_noise
        recorded = np.asarray(savgol_filter(friction, *SMOOTH))
    else:
        recorded = np.full(len(velocity), math.nan)
        friction, friction_deviation = _balance(run, base, force, velocity, window, displacement_noise)
    last = _last_sliding(slide_rate, friction, 4 * velocity_deviation)
    impulse = cumulative_trapezoid(friction, dx=dt, initial=0.0)
    return Signals(
        run,
        base,
        ahead,
        force,
        velocity,
        slide,
        slide_rate,
        friction,
        displacement_noise,
        friction_noise,
        base_noise,
        velocity_deviation,
        friction_deviation,
        _held(slide_rate, last) * dt,
        impulse,
        cumulative_trapezoid(impulse, dx=dt, initial=0.0),
        np.where(last < 0, 0.0, np.sign(slide_rate[last])),
        recorded,
    )


def _last_sliding(slide_rate: Samples, friction: Samples, still: float) -> np.ndarray:
    """The sample so far at which the mass last slid, -1 for none: moved fast over its guide, or against a
    force as large as that of sliding, for what rings in stick moves, too; `still` is a velocity [m/s] that
    noise may show."""
    speed = np.abs(slide_rate)
    moving = speed > max(RINGS * speed.max(), still)
    fast = speed >= FAST * speed.max()
    sliding = np.median(np.abs(friction[fast]))
    resisted = (slide_rate * friction < 0) & (np.abs(friction) > ALL_BUT * sliding)
    return np.maximum.accumulate(np.where(moving & (fast | resisted), np.arange(len(speed)), -1))


def _held(slide_rate: Samples, last: np.ndarray) -> Samples:
    """For how many samples the contact has held, since the mass came to rest from where it `last` slid, or
    since the first sample: a mass that slows down slides until its velocity passes through zero."""
    at = np.arange(len(slide_rate))
    turns = np.append(slide_rate[1:] * slide_rate[:-1] <= 0, True)
    turn = np.minimum.accumulate(np.where(turns, at, len(at) - 1)[::-1])[::-1]
    following = np.minimum(turn + 1, len(at) - 1)
    change = slide_rate[turn] - slide_rate[following]
    arrest = turn + np.divide(slide_rate[turn], change, out=np.zeros(len(at)), where=change != 0)
    return np.maximum(at - np.where(last < 0, 0.0, arrest[last.clip(0)]), 0.0)


def base_motion(run: Run, time: Samples) -> tuple[Samples, Samples]:
    """Base displacement [m] of a run at its sample times, or at others where it was not recorded (zero where
    the run has none), and at `AHEAD` more of them after the last (empty where nobody knows).

    A base that was not recorded is base_amplitude sin(2 pi frequency t + phase). A recorded one is smoothed
    as far as that leaves no more than the channel's noise, which would otherwise shake the simulated contact:
    in stick the mass rings at a frequency at which little else excites it.
    """
    if run.base is not None:
        return _smoothed(time, run.base)
    if run.frequency is None or run.base_amplitude is None:
        return np.zeros_like(time), np.zeros(AHEAD)
    longer = _longer(time)
    base = run.base_amplitude * np.sin(2 * math.pi * run.frequency * longer + run.base_phase)
    return base[: len(time)], base[len(time) :]


def _longer(time: Samples) -> Samples:
    """Uniform times with `AHEAD` more after the last."""
    return np.concatenate([time, time[-1] + (time[1] - time[0]) * np.arange(1, AHEAD + 1)])


def _smoothed(time: Samples, base: Samples) -> tuple[Samples, Samples]:
    """The base as the Fourier series of one sine, of a periodic motion up to order `ORDERS`, or as a quintic
    spline through the fewest equal pieces, whichever first leaves no more than the noise; the base itself
    where none does. And the base after the last sample, where it is a series."""
    noise, exact = estimate_noise(base), EXACT * float(np.ptp(base))
    for smooth in _smoother(time, base):
        within = smooth[: len(base)]
        left = base - within
        size = math.sqrt(np.mean(left**2))
        white = abs(np.sum(left[1:] * left[:-1])) < WHITE * np.sum(left**2)
        if size < max((WHITE_EXCESS if white else NOISE_EXCESS) * noise, exact):
            return within, smooth[len(base) :]
    return base, np.zeros(0)


def _smoother(time: Samples, base: Samples) -> Iterator[Samples]:
    """The base in ways that follow it ever more closely; beyond the last sample where that can be told."""
    angle = 2 * math.pi * fit_harmonic(time, base).frequency * (_longer(time) - time[0])
    if angle[len(time) - 1] > 2 * math.pi * LEAST_CYCLES:
        yield _series(angle, base, 1)
        yield _series(angle, base, ORDERS)
    for count in (2**power for power in range(2, int(math.log2(len(time) / PIECE)) + 1)):
        inner = np.linspace(time[0], time[-1], count + 1)
        knots = np.concatenate([np.repeat(time[0], DEGREE), inner, np.repeat(time[-1], DEGREE)])
        yield make_lsq_spline(time, base, knots, DEGREE)(time)


def _series(angle: Samples, base: Samples, orders: int) -> Samples:
    """The Fourier series of the base, up to this order, in an angle that grows by 2 pi in a period and may go
    on after the base."""
    waves = np.outer(angle, np.arange(1, orders + 1))
    design = np.concatenate([np.ones((len(angle), 1)), np.cos(waves), np.sin(waves)], axis=1)
    return design @ np.linalg.lstsq(design[: len(base)], base, rcond=None)[0]


def natural_period(rig: KnownRig) -> float | None:
    """2 pi sqrt(m/K) [s]; None for a rig without springs."""
    return 2 * math.pi * math.sqrt(rig.mass / rig.stiffness) if rig.stiffness > 0 else None


def _window(period: float, dt: float, samples: int) -> int:
    """An odd number of samples that spans a twenty-fifth of the natural period, at least 7."""
    window = max(7, 2 * round(period / dt / 50) + 1)
    return min(window, samples - 1 + samples % 2)


def balance(signal: Signals) -> tuple[Samples, float]:
    """The friction force that the equation of motion asks for, m x'' + c x' + K x - k_d y - c_d y' - u [N],
    and its standard deviation; derivatives from parabolas and cubics through a few samples."""
    run = signal.run
    window = _window(natural_period(run.rig) or 100 * run.interval, run.interval, len(run.time))
    return _balance(run, signal.base, signal.force, signal.velocity, window, signal.displacement_noise)


def _balance(
    run: Run, base: Samples, force: Samples, velocity: Samples, window: int, noise: float
) -> tuple[Samples, float]:
    rig, dt = run.rig, run.interval
    wide = min(2 * window + 1, len(run.time) - 1 + len(run.time) % 2)
    acceleration = np.asarray(savgol_filter(run.displacement, wide, 3, deriv=2, delta=dt))
    base_rate = np.asarray(savgol_filter(base, window, 2, deriv=1, delta=dt))
    friction = rig.mass * acceleration + rig.damping * velocity + rig.stiffness * run.displacement
    friction -= rig.drive_stiffness * base + rig.drive_damping * base_rate + force
    gain = math.sqrt(np.sum(savgol_coeffs(wide, 3, deriv=2, delta=dt) ** 2))
    return friction, rig.mass * noise * gain

"""What a data set holds, what it lacks, and what that costs: the facts behind `jaxstick check`."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from jaxstick.formats.harmonic import fit_harmonic
from jaxstick.noise import ChannelNoise, noise_summary
from jaxstick.outliers import OF_MOTION, outliers
from jaxstick.record import AssumedConstants, DataSet, KnownRig, Run

FEW_CYCLES = 5
FEW_SAMPLES_PER_CYCLE = 100
FEW_SAMPLES_PER_RING = 6
SAME_FREQUENCY = 0.02
NOISE_FACTOR = 2.0

_UNITS = {"displacement": "m", "base": "m", "friction": "N", "force": "N", "velocity": "m/s"}
_CONSTANTS = {"A": "N", "B": "s/m", "C": "N", "D": "N s/m", "k1": "N/m"}
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))


@dataclass(frozen=True)
class RunFacts:
    """One run in numbers, SI; None where a number has no meaning.

    frequency: as the base shows it, else as stated [Hz]; ratio: frequency over the natural frequency;
    amplitudes: half the range of each recorded channel.
    """

    file: str
    hold_out: bool
    samples: int
    rate: float
    duration: float
    frequency: float | None
    ratio: float | None
    cycles: float | None
    samples_per_cycle: float | None
    base_amplitude: float | None
    amplitudes: dict[str, float]


@dataclass(frozen=True)
class Finding:
    """One sentence on a data set. kind: "missing" (and what that costs), "warning", or "notice" from reading
    it."""

    kind: str
    text: str


@dataclass(frozen=True)
class Section:
    """A table of words: a title, the columns' names, and rows of as many cells."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Description:
    """A data set in plain data: numbers for programs, `sections` and `findings` for people."""

    name: str
    folder: str | None
    sha256: str | None
    rig: KnownRig
    natural_frequency: float
    assumed: AssumedConstants
    runs: tuple[RunFacts, ...]
    noise: tuple[ChannelNoise, ...]
    sections: tuple[Section, ...]
    findings: tuple[Finding, ...]


def describe(dataset: DataSet) -> Description:
    """Looks through a data set."""
    runs = tuple(_facts(run) for run in dataset.runs)
    noise = noise_summary(dataset)
    return Description(
        name=dataset.name,
        folder=None if dataset.folder is None else str(dataset.folder),
        sha256=dataset.sha256,
        rig=dataset.rig,
        natural_frequency=dataset.rig.natural_frequency,
        assumed=dataset.assumed,
        runs=runs,
        noise=noise,
        sections=(_rig_section(dataset), _runs_section(runs), _channels_section(runs, noise)),
        findings=(
            *_missing(dataset, runs),
            *_sampling(dataset, runs),
            *_noise_findings(noise),
            *_outlier_findings(dataset, noise),
            *(Finding("notice", text) for text in dataset.notices),
        ),
    )


def quantity(value: float | None, unit: str) -> str:
    """A number with a unit for reading: `0.0103, "m"` is '10.3 mm'; None is a dash."""
    if value is None:
        return "-"
    factor, prefix = 1.0, ""
    if unit in _UNITS.values() and value:
        scales = (scale for scale in _PREFIXES if abs(value) >= 0.9995 * scale[0])
        factor, prefix = next(scales, _PREFIXES[-1])
    return f"{value / factor:.4g} {prefix}{unit}".rstrip()


def _facts(run: Run) -> RunFacts:
    interval, samples = run.interval, len(run.time)
    frequency, base_amplitude = run.frequency, run.base_amplitude
    if run.base is not None:
        base = fit_harmonic(run.time, run.base)
        if base.frequency * samples * interval >= 1:
            frequency, base_amplitude = base.frequency, base.amplitude
    natural = run.rig.natural_frequency
    return RunFacts(
        file=run.file,
        hold_out=run.hold_out,
        samples=samples,
        rate=1 / interval,
        duration=samples * interval,
        frequency=frequency,
        ratio=frequency / natural if frequency is not None and natural else None,
        cycles=frequency * samples * interval if frequency is not None else None,
        samples_per_cycle=1 / (frequency * interval) if frequency is not None else None,
        base_amplitude=base_amplitude,
        amplitudes={name: float(np.ptp(channel)) / 2 for name, channel in run.channels.items()},
    )


def _rig_section(dataset: DataSet) -> Section:
    rig = dataset.rig
    rows = [
        ("mass m", quantity(rig.mass, "kg")),
        ("stiffness K", quantity(rig.stiffness, "N/m")),
        ("drive stiffness k_d", quantity(rig.drive_stiffness, "N/m")),
        ("damping c", quantity(rig.damping, "N s/m")),
        ("drive damping c_d", quantity(rig.drive_damping, "N s/m")),
        ("natural frequency", quantity(rig.natural_frequency, "Hz")),
        ("friction against", rig.friction_against),
    ]
    for name, unit in _CONSTANTS.items():
        values = dict.fromkeys(quantity(getattr(run.assumed, name), unit) for run in dataset.runs)
        rows.append((f"assumed {name}", ", ".join(values)))
    for key, given in dataset.effects.items():
        values = ", ".join(f"{name} = {value:.4g}" for name, value in given.items())
        rows.append((f"effect {key}", values or "at null"))
    return Section("Rig", ("what", "value"), tuple(rows))


def _runs_section(runs: tuple[RunFacts, ...]) -> Section:
    columns = ("run", "samples", "rate", "duration", "drive", "f/fn", "cycles", "base", "travel", "use")
    rows = tuple(
        (
            run.file,
            str(run.samples),
            quantity(run.rate, "Hz"),
            f"{run.duration:.4g} s",
            quantity(run.frequency, "Hz"),
            quantity(run.ratio, ""),
            quantity(run.cycles, ""),
            quantity(run.base_amplitude, "m"),
            quantity(run.amplitudes["displacement"], "m"),
            "held out" if run.hold_out else "fit",
        )
        for run in runs
    )
    return Section("Runs", columns, rows)


def _channels_section(runs: tuple[RunFacts, ...], noise: tuple[ChannelNoise, ...]) -> Section:
    amplitudes = {(run.file, name): value for run in runs for name, value in run.amplitudes.items()}
    rows = tuple(
        (
            entry.file,
            entry.channel,
            quantity(amplitudes[entry.file, entry.channel], _UNITS[entry.channel]),
            quantity(entry.found.sd, _UNITS[entry.channel]),
            quantity(entry.stated, _UNITS[entry.channel]),
            quantity(entry.found.lag1, ""),
        )
        for entry in noise
    )
    return Section("Channels", ("run", "channel", "amplitude", "noise found", "stated", "lag 1"), rows)


def _missing(dataset: DataSet, runs: tuple[RunFacts, ...]) -> Iterator[Finding]:
    silent = [run.file for run in dataset.runs if run.friction is None]
    if silent:
        yield Finding(
            "missing",
            f"no friction force in {_names(silent, dataset)}: the friction law is read from the motion "
            "alone, the constants are less certain, and faults of a force measurement cannot be seen.",
        )
    stated = [run.file for run in dataset.runs if run.base is None and run.base_amplitude is not None]
    if stated:
        yield Finding(
            "missing",
            f"no base motion in {_names(stated, dataset)}: it is taken as the pure sine that is stated, so "
            "harmonics, gain and delay of the drive cannot be seen.",
        )
    frequencies = [run.frequency for run in runs if run.frequency is not None]
    if frequencies and max(frequencies) <= (1 + SAME_FREQUENCY) * min(frequencies):
        yield Finding(
            "missing",
            f"only one drive frequency ({min(frequencies):.4g} Hz): stiffness, damping, a constant force and "
            "the level of friction can make up for one another; a run at another frequency would separate "
            "them.",
        )
    if not any(run.hold_out for run in runs):
        yield Finding(
            "missing",
            "no run is held out: a finding is judged on stretches of the records it comes from; hold_out = "
            "true keeps a run for judging.",
        )
    unknown = [name for name in _CONSTANTS if any(getattr(run.assumed, name) is None for run in dataset.runs)]
    if unknown:
        yield Finding(
            "missing",
            f"no assumed {', '.join(unknown)}: there is nothing to compare an identified value with, and no "
            "simulation with today's constants.",
        )


def _sampling(dataset: DataSet, runs: tuple[RunFacts, ...]) -> Iterator[Finding]:
    for run in runs:
        if run.cycles is not None and run.cycles < FEW_CYCLES:
            yield Finding(
                "warning",
                f"{run.file} has {run.cycles:.2g} cycles of the drive: what differs from cycle to cycle "
                "cannot be told from what repeats.",
            )
        if run.samples_per_cycle is not None and run.samples_per_cycle < FEW_SAMPLES_PER_CYCLE:
            yield Finding(
                "warning",
                f"{run.file} has {run.samples_per_cycle:.3g} samples a cycle: breakaway and arrest are "
                "blurred, and the noise found is too high.",
            )
    for run in dataset.runs:
        if run.assumed.k1 is not None:
            ring = math.sqrt((run.rig.stiffness + run.assumed.k1) / run.rig.mass) / (2 * math.pi)
            if 1 / run.interval < FEW_SAMPLES_PER_RING * ring:
                yield Finding(
                    "warning",
                    f"{run.file} is sampled at {1 / run.interval:.4g} Hz, and the mass would ring on the "
                    f"assumed k1 at {ring:.4g} Hz: sampling this coarse says little about k1.",
                )


def _noise_findings(noise: tuple[ChannelNoise, ...]) -> Iterator[Finding]:
    for entry in noise:
        unit, found = _UNITS[entry.channel], entry.found
        place = f"{entry.file}, {entry.channel}"
        if entry.stated is not None and found.sd > NOISE_FACTOR * entry.stated:
            yield Finding(
                "warning",
                f"{place}: the record shows noise of {quantity(found.sd, unit)}, more than the stated "
                f"{quantity(entry.stated, unit)}: intervals come out too narrow.",
            )
        if entry.stated is not None and found.sd < entry.stated / NOISE_FACTOR:
            yield Finding(
                "warning",
                f"{place}: the record shows noise of {quantity(found.sd, unit)}, less than the stated "
                f"{quantity(entry.stated, unit)}: unless that holds slow noise too, the channel gets too "
                "little weight.",
            )
        if found.coloured:
            yield Finding(
                "warning",
                f"{place}: what is left beside the motion is not white (neighbouring samples correlate by "
                f"{found.lag1:.2f}): slow noise, a filter, or motion too fast for the sampling.",
            )


def _outlier_findings(dataset: DataSet, noise: tuple[ChannelNoise, ...]) -> Iterator[Finding]:
    runs = {run.file: run for run in dataset.runs}
    for entry in noise:
        if entry.channel not in OF_MOTION:
            continue
        run = runs[entry.file]
        places, off = outliers(run.channels[entry.channel], entry.found.sd)
        if len(places):
            samples = "sample is" if len(places) == 1 else "samples are"
            yield Finding(
                "warning",
                f"{entry.file}, {entry.channel}: {len(places)} single {samples} off by up to "
                f"{quantity(float(np.abs(off).max()), _UNITS[entry.channel])}, the first at "
                f"{run.time[places[0]]:.6g} s: bit errors of a converter, or a loose plug.",
            )


def _names(files: list[str], dataset: DataSet) -> str:
    return "any run" if len(files) == len(dataset.runs) else ", ".join(files)

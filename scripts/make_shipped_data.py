"""Writes the shipped SYNTHETIC data sets: `python scripts/make_shipped_data.py --out DIR`.

Each run is the reference model of the contact `loaded` (tests/reference/loaded.py, event-driven, nothing of
jaxstick) after one cycle of transient, plus white Gaussian noise from a seed. The bytes are always the same:
`RandomState` has a frozen stream, and the numbers are rounded far above the error of the solution.
"""

import argparse
import sys
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.reference import loaded
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

TRANSIENT_CYCLES = 1


@dataclass(frozen=True)
class Channel:
    """A column: its name, SI units per unit of the column, decimals written, noise in the column's unit."""

    name: str
    unit: float
    decimals: int
    noise: float = 0.0


@dataclass(frozen=True)
class Plan:
    """One run: frequency [Hz], base amplitude [m], its phase at the first sample [rad], cycles recorded."""

    frequency: float
    amplitude: float
    phase: float
    cycles: int
    hold_out: bool = False


@dataclass(frozen=True)
class Rig:
    """A data set: what is true, what the rig's owner assumes, how it was measured.

    `damping` is the key and value in rig.toml that say c; `assumed` has the keys A, B, C, D, k1 in SI units.
    """

    name: str
    story: str
    true: Oscillator
    damping: tuple[str, float]
    assumed: dict[str, float]
    rate: float
    seed: int
    channels: tuple[Channel, Channel, Channel, Channel]
    plans: tuple[Plan, ...]
    unmodelled: str = ""
    """What acts in the simulation and is not in the model of jaxstick, in a sentence for the README."""


ASSUMED_KEYS = {"A": "A_n", "B": "B_s_per_m", "C": "C_n", "D": "D_n_s_per_m", "k1": "k1_n_per_m"}

RIG1987 = Rig(
    name="rig1987",
    story="The stick-slip rig of the 1987 Barcelona paper: 2.38 kg between springs on a guide, pulled by a "
    "vibrating table, at the frequency ratios of its figures 7 and 8 (0.326, 0.190, 0.109, 0.071, 0.046).",
    true=Oscillator(
        mass=2.38,
        stiffness=1986.0,
        damping=0.207 / pi * sqrt(1986.0 * 2.38),
        A=1.05,
        B=100.0,
        C=6.42,
        D=0.002,
        k1=99300.0,
    ),
    damping=("log_decrement", 0.207),
    assumed={"A": 1.49, "B": 80.0, "C": 5.60, "D": 0.003, "k1": 149000.0},
    rate=500.0,
    seed=1987,
    channels=(
        Channel("time_s", 1.0, 3),
        Channel("base_mm", 1e-3, 3, 0.005),
        Channel("displacement_mm", 1e-3, 3, 0.008),
        Channel("friction_n", 1.0, 3, 0.03),
    ),
    plans=(
        Plan(1.499, 10.325e-3, 0.3, 6),
        Plan(0.874, 10.325e-3, 1.1, 6),
        Plan(0.501, 10.325e-3, 2.6, 6, hold_out=True),
        Plan(0.326, 10.325e-3, 4.0, 5),
        Plan(0.211, 10.325e-3, 5.2, 5),
    ),
)

TRIBOMETER = Rig(
    name="tribometer",
    story="A pin-on-plate tribometer head: 50 g on leaf springs (40 Hz), its pin loaded with about 0.6 N on "
    "a fixed plate, pulled by a piezo stage with strokes of some 100 um.",
    true=Oscillator(
        mass=0.05,
        stiffness=3150.0,
        damping=0.6,
        A=0.05,
        B=120.0,
        C=0.13,
        D=0.8,
        k1=120000.0,
    ),
    damping=("damping_n_s_per_m", 0.6),
    assumed={"A": 0.09, "B": 60.0, "C": 0.10, "D": 2.0, "k1": 60000.0},
    rate=4000.0,
    seed=2026,
    channels=(
        Channel("time_ms", 1e-3, 2),
        Channel("base_um", 1e-6, 2, 0.1),
        Channel("displacement_um", 1e-6, 2, 0.1),
        Channel("friction_n", 1.0, 4, 0.0015),
    ),
    plans=(
        Plan(3.0, 300e-6, 0.5, 4),
        Plan(5.0, 300e-6, 1.9, 6),
        Plan(8.0, 250e-6, 3.1, 8),
        Plan(12.0, 200e-6, 4.4, 10, hold_out=True),
        Plan(18.0, 180e-6, 5.6, 12),
        Plan(26.0, 150e-6, 0.9, 14),
    ),
)

CUBIC = 1.5e6
"""By how much the leaf springs stiffen [N/m^3]."""


def stiffening(_t: float, x: float, _v: float) -> float:
    """-CUBIC x^3 [N]."""
    return -CUBIC * x**3


LEAF_SPRINGS = Rig(
    name="leaf_springs",
    story="A carriage of 1.3 kg between leaf springs (6 Hz) on a greased rail, shaken by a table with "
    "strokes of some millimetres.",
    true=Oscillator(
        mass=1.3,
        stiffness=1850.0,
        damping=3.1,
        A=0.7,
        B=45.0,
        C=2.4,
        D=1.6,
        k1=60000.0,
        extra_force=stiffening,
    ),
    damping=("damping_n_s_per_m", 3.1),
    assumed={"A": 1.0, "B": 70.0, "C": 2.0, "D": 2.5, "k1": 90000.0},
    rate=500.0,
    seed=361,
    channels=(
        Channel("time_s", 1.0, 3),
        Channel("base_mm", 1e-3, 3, 0.004),
        Channel("displacement_mm", 1e-3, 3, 0.006),
        Channel("friction_n", 1.0, 3, 0.02),
    ),
    plans=(
        Plan(0.8, 6e-3, 0.4, 2),
        Plan(1.3, 6e-3, 1.7, 3),
        Plan(2.1, 5e-3, 3.3, 5, hold_out=True),
        Plan(3.2, 4e-3, 4.9, 8),
        Plan(4.4, 3.5e-3, 5.8, 11, hold_out=True),
        Plan(7.5, 4e-3, 2.2, 20),
    ),
    unmodelled=f"Missing in the model: the springs stiffen, -k3 x^3 with k3 = {CUBIC:g} N/m^3. "
    "`jaxstick diagnose` is not told.",
)

RIGS = (RIG1987, TRIBOMETER, LEAF_SPRINGS)


def record(rig: Rig, plan: Plan, random: np.random.RandomState) -> np.ndarray:
    """The channels of one run in their own units, (samples, 4), noise included, time beginning at 0."""
    skip = TRANSIENT_CYCLES / plan.frequency
    count = int(plan.cycles / plan.frequency * rig.rate)
    time = np.arange(count) / rig.rate
    drive = SineDrive(plan.frequency, plan.amplitude, plan.phase - 2.0 * pi * plan.frequency * skip)
    run = loaded.simulate(rig.true, drive, np.concatenate([[0.0], skip + time]))
    base = np.array([drive.position(t) for t in run.time[1:]])
    columns = [time, base, run.x[1:], run.F[1:]]
    return np.stack(
        [
            values / channel.unit + channel.noise * random.standard_normal(count)
            for values, channel in zip(columns, rig.channels, strict=True)
        ],
        axis=1,
    )


def csv(rig: Rig, plan: Plan, rows: np.ndarray) -> str:
    """The text of one run's CSV file."""
    lines = [
        f"# SYNTHETIC, not measured: {rig.name}, base {1e3 * plan.amplitude:g} mm at {plan.frequency:g} Hz",
        "# made by scripts/make_shipped_data.py: event-driven simulation, white noise; see data/README.md",
        ",".join(channel.name for channel in rig.channels),
    ]
    decimals = [channel.decimals for channel in rig.channels]
    for row in rows:
        lines.append(",".join(f"{round(v, n) + 0.0:.{n}f}" for v, n in zip(row, decimals, strict=True)))
    return "\n".join(lines) + "\n"


def rig_toml(rig: Rig) -> str:
    """The text of rig.toml."""
    lines = [
        f"# SYNTHETIC, not measured. {rig.story.split(':')[0]}.",
        "# Made by scripts/make_shipped_data.py; the true constants are in data/README.md.",
        "[rig]",
        f"mass_kg = {rig.true.mass!r}",
        f"stiffness_n_per_m = {rig.true.stiffness!r}",
        f"drive_stiffness_n_per_m = {rig.true.stiffness!r}",
        f"{rig.damping[0]} = {rig.damping[1]!r}",
        f'friction_against = "{rig.true.friction_against}"',
        "",
        "[assumed] # deliberately not the true ones",
        *(f"{key} = {rig.assumed[name]!r}" for name, key in ASSUMED_KEYS.items()),
        "",
        "[noise]",
        *(f"{channel.name} = {channel.noise!r}" for channel in rig.channels[1:]),
    ]
    for number, plan in enumerate(rig.plans, 1):
        lines += [
            "",
            "[[run]]",
            f'file = "{file_name(number)}"',
            f"frequency_hz = {plan.frequency!r}",
            f"base_amplitude_mm = {round(1e3 * plan.amplitude, 6)!r}",
        ]
        if plan.hold_out:
            lines.append("hold_out = true")
    return "\n".join(lines) + "\n"


def readme() -> str:
    """The text of README.md."""
    parts = [
        "# Shipped data",
        "",
        "The data sets are SYNTHETIC: no rig was measured. They are made by",
        "",
        "    python scripts/make_shipped_data.py --out DIR",
        "",
        "which writes the same bytes every time. Each run is an event-driven simulation",
        "(`tests/reference/loaded.py`, plain Python, nothing of jaxstick) of m x'' + c x' + K x = K y(t) + F",
        "with the contact `loaded`, its first cycle dropped, plus white Gaussian noise. The constants under",
        "`[assumed]` in `rig.toml` are deliberately wrong; what the simulation used is below.",
    ]
    units = {"A": "N", "B": "s/m", "C": "N", "D": "N s/m", "k1": "N/m"}
    for rig in RIGS:
        noise = ", ".join(f"{c.name} {c.noise:g}" for c in rig.channels[1:])
        held_out = ", ".join(file_name(n) for n, plan in enumerate(rig.plans, 1) if plan.hold_out)
        parts += [
            "",
            f"## {rig.name}",
            "",
            rig.story,
            "",
            "| constant | unit | true | assumed |",
            "| --- | --- | --- | --- |",
            *(f"| {k} | {units[k]} | {getattr(rig.true, k):g} | {v:g} |" for k, v in rig.assumed.items()),
            "",
            f"m = {rig.true.mass:g} kg, K = k_d = {rig.true.stiffness:g} N/m, "
            f"c = {rig.true.damping:.4g} N s/m; friction against the ground.",
            f"Sampled at {rig.rate:g} Hz; noise (standard deviation): {noise}; seed {rig.seed}.",
            f"Held out: {held_out}.",
            *([rig.unmodelled] if rig.unmodelled else []),
        ]
    parts += [
        "",
        "In rig1987 c follows from damping ratio = log_decrement/(2 pi), and D |v| stays far below the noise",
        "of the force channel: its D cannot be identified.",
    ]
    return "\n".join(parts) + "\n"


def file_name(number: int) -> str:
    """run-01.csv, run-02.csv, ..."""
    return f"run-{number:02d}.csv"


def write(out: Path, overwrite: bool) -> None:
    """Write the data sets and the README into `out`; FileExistsError where a target has content."""
    targets = [out / "README.md", *(out / rig.name for rig in RIGS)]
    for target in targets:
        if not overwrite and target.exists() and (target.is_file() or any(target.iterdir())):
            raise FileExistsError(f"{target} has content already; give --overwrite to replace it")
    for rig in RIGS:
        folder = out / rig.name
        folder.mkdir(parents=True, exist_ok=True)
        random = np.random.RandomState(rig.seed)
        for number, plan in enumerate(rig.plans, 1):
            text = csv(rig, plan, record(rig, plan, random))
            (folder / file_name(number)).write_text(text, encoding="utf-8", newline="\n")
        (folder / "rig.toml").write_text(rig_toml(rig), encoding="utf-8", newline="\n")
    (out / "README.md").write_text(readme(), encoding="utf-8", newline="\n")


def main() -> int:
    """The command; 0 done, 2 where a folder would be overwritten."""
    parser = argparse.ArgumentParser(description="Write the shipped synthetic data sets.")
    parser.add_argument("--out", type=Path, required=True, help="folder for the data sets' folders")
    parser.add_argument("--overwrite", action="store_true", help="replace what is there")
    options = parser.parse_args()
    try:
        write(options.out, options.overwrite)
    except FileExistsError as refusal:
        print(refusal, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

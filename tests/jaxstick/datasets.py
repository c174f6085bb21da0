"""Small data sets for tests: a mass that a base drags through play, as slow stick-slip does."""

from pathlib import Path

import numpy as np

STIFFNESS = 2000.0
AMPLITUDE = 0.010
FREQUENCY = 1.0
PLAY = 0.003

RIG = """\
[rig]
mass_kg = 2.38
stiffness_n_per_m = 2000.0
log_decrement = 0.207

[assumed]
A_n = 1.5
B_s_per_m = 100.0
C_n = 5.0
D_n_s_per_m = 0.002
k1_n_per_m = 100000.0

[[run]]
file = "run-01.csv"
frequency_hz = 1.0
base_amplitude_mm = 10.0
"""


def record(samples: int = 128, per_cycle: int = 64) -> dict[str, np.ndarray]:
    """Channels in SI by quantity: base y = AMPLITUDE sin(2 pi FREQUENCY t), x dragged behind it, F = -K (y -
    x)."""
    time = np.arange(samples) / (per_cycle * FREQUENCY)
    base = AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * time)
    displacement = np.zeros(samples)
    for i in range(1, samples):
        displacement[i] = np.clip(displacement[i - 1], base[i] - PLAY, base[i] + PLAY)
    friction = -STIFFNESS * (base - displacement)
    return {"time": time, "base": base, "displacement": displacement, "friction": friction}


def csv_text(columns: dict[str, np.ndarray], separator: str = ",", end: str = "\n") -> str:
    """A CSV text with full precision."""
    rows = zip(*(map(repr, samples.tolist()) for samples in columns.values()), strict=True)
    return end.join([separator.join(columns), *(separator.join(row) for row in rows)]) + end


def standard_csv() -> str:
    """The standard record as run-01.csv holds it: time_s, base_m, displacement_m, friction_n."""
    channels = record()
    units = {"time": "s", "base": "m", "displacement": "m", "friction": "n"}
    return csv_text({f"{name}_{units[name]}": samples for name, samples in channels.items()})


def write(folder: Path, rig: str = RIG, **files: str) -> Path:
    """Writes a data set: rig.toml and run-01.csv, or the files given as run_01=text; returns its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    for name, text in (files or {"run_01": standard_csv()}).items():
        (folder / f"{name.replace('_', '-')}.csv").write_text(text, encoding="utf-8", newline="")
    return folder

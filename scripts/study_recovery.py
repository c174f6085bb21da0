"""Recovery study: data sets of known constants, made by the independent reference, fitted blindly.

Each data set has the paper's rig at five frequencies, random constants, random noise levels, and assumed
constants wrong by a factor of up to 3 each. Reported per constant: how many fits reach the right basin (every
bounded constant within 4 standard errors), how often the 95 % interval covers the truth, and the median error
over the one a normal estimator at the Cramer-Rao bound of the whole records would have.

    python -m scripts.study_recovery --sets 200 --out out/recovery.jsonl [--workers 2]

One line of JSON a data set; a rerun continues where it stopped.
"""

from __future__ import annotations

import json
import math
import multiprocessing
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.stats import beta

from fitting.fit import fit
from fitting.newton import settle
from fitting.problem import pose
from fitting.segments import Segment
from fitting.settings import Settings
from fitting.stage import stage
from jaxstick.compilation_cache import set_up_jax
from jaxstick.record import CONSTANTS, AssumedConstants, DataSet, KnownRig, Noise, Run
from tests.reference import loaded, rig1987
from tests.reference.drive import SineDrive
from tests.reference.oscillator import Oscillator

INTERVAL = 2e-3
SAMPLES = 2400
TRANSIENT_CYCLES = 1.0


def draw(seed: int) -> tuple[DataSet, dict[str, float]]:
    """A data set and its true constants; everything random comes from the seed."""
    random = np.random.default_rng([20261121, seed])

    def log_uniform(low: float, high: float) -> float:
        return float(math.exp(random.uniform(math.log(low), math.log(high))))

    static = log_uniform(4.0, 9.0)
    weakening = random.uniform(0.08, 0.3)
    truth = {
        "A": static * weakening,
        "B": log_uniform(40.0, 200.0),
        "C": static * (1 - weakening),
        "D": 0.002 if seed % 4 == 0 else log_uniform(0.3, 6.0),
        "k1": log_uniform(3e4, 2e5),
    }
    noise = Noise(displacement=8e-6 * log_uniform(0.5, 2.0), friction=0.03 * log_uniform(0.5, 2.0))
    assumed = AssumedConstants(**{name: value * log_uniform(1 / 3, 3.0) for name, value in truth.items()})
    A, B, C, D, k1 = (truth[name] for name in CONSTANTS)
    reference = Oscillator(rig1987.MASS, rig1987.STIFFNESS, rig1987.DAMPING, A, B, C, D, k1)
    rig = KnownRig(rig1987.MASS, rig1987.STIFFNESS, rig1987.STIFFNESS, rig1987.DAMPING, 0.0)
    runs = tuple(
        _record(reference, rig1987.drive(ratio), rig, assumed, noise, f"run-{number}.csv", random)
        for number, ratio in enumerate(rig1987.STOPS)
    )
    return DataSet(name=f"set {seed}", rig=rig, assumed=assumed, noise=noise, runs=runs), truth


def _record(
    reference: Oscillator,
    drive: SineDrive,
    rig: KnownRig,
    assumed: AssumedConstants,
    noise: Noise,
    file: str,
    random: np.random.Generator,
) -> Run:
    skipped = round(TRANSIENT_CYCLES * drive.period / INTERVAL)
    times = INTERVAL * np.arange(skipped + SAMPLES)
    exact = loaded.simulate(reference, drive, times, tolerance=1e-9)
    kept = slice(skipped, None)
    assert noise.displacement is not None and noise.friction is not None
    return Run(
        file=file,
        time=np.asarray(times[:SAMPLES], float),
        displacement=exact.x[kept] + noise.displacement * random.standard_normal(SAMPLES),
        friction=exact.F[kept] + noise.friction * random.standard_normal(SAMPLES),
        base=np.array([drive.position(t) for t in times[kept]]),
        frequency=drive.frequency,
        base_amplitude=drive.base_amplitude,
        rig=rig,
        assumed=assumed,
    )


def cramer_rao(dataset: DataSet, truth: dict[str, float], settings: Settings) -> dict[str, float]:
    """Standard deviations of the constants at the Cramer-Rao bound of the whole records, white noise."""
    problem = pose(dataset, settings)
    runs = [Segment(number, 0, len(signal.run.time)) for number, signal in enumerate(problem.chosen)]
    whole = stage(problem, None, runs, truth["k1"], settings)
    point = problem.unknowns.coordinates(truth)
    starts, _ = settle(whole.misfit, whole.lanes, point, np.asarray(whole.lanes.start), iterations=3)
    _, curvature = whole.misfit.scores(whole.lanes, point, starts, whole.blocks)
    deviation = np.sqrt(np.diag(np.linalg.inv(curvature.sum(0))))
    return {
        unknown.name: float(spot * (truth[unknown.name] if unknown.kind == "log" else unknown.scale))
        for unknown, spot in zip(problem.unknowns.members, deviation, strict=True)
    }


def study(seed: int) -> dict:
    """One line of the study."""
    settings = Settings(workers=1, seed=seed)
    dataset, truth = draw(seed)
    result = fit(dataset, settings)
    bound = cramer_rao(dataset, truth, settings)
    return {
        "seed": seed,
        "outcome": result.outcome,
        "chi2": result.chi2_per_sample,
        "constants": {
            c.name: {
                "truth": truth[c.name],
                "value": c.value,
                "low": c.low,
                "high": c.high,
                "standard_error": c.standard_error,
                "bound": bound[c.name],
            }
            for c in result.constants
        },
    }


def summary(lines: list[dict]) -> Table:
    """The figures per constant; intervals of proportions are Clopper and Pearson's."""
    table = Table(title=f"recovery of {len(lines)} data sets")
    for head in (
        "constant",
        "n",
        "bounded",
        "coverage 95 %",
        "(interval)",
        "error / Cramer-Rao",
        "worst |z|",
    ):
        table.add_column(head, justify="right")
    right = 0
    for line in lines:
        right += all(
            abs(c["value"] - c["truth"]) <= 4 * c["standard_error"]
            for c in line["constants"].values()
            if c["low"] is not None and c["high"] is not None and c["standard_error"]
        )
    for name in CONSTANTS:
        rows = [line["constants"][name] for line in lines]
        bounded = [row for row in rows if row["low"] is not None and row["high"] is not None]
        covered = sum(_covers(row) for row in rows)
        low, high = _proportion(covered, len(rows))
        ratio = np.median([abs(row["value"] - row["truth"]) / row["bound"] for row in rows]) / 0.6745
        worst = max((abs(r["value"] - r["truth"]) / r["standard_error"] for r in bounded), default=math.nan)
        table.add_row(
            name,
            str(len(rows)),
            str(len(bounded)),
            f"{100 * covered / len(rows):.1f} %",
            f"{100 * low:.1f} to {100 * high:.1f}",
            f"{ratio:.2f}",
            f"{worst:.1f}",
        )
    table.caption = f"right basin: {right} of {len(lines)}"
    return table


def _covers(row: dict) -> bool:
    low = -math.inf if row["low"] is None else row["low"]
    high = math.inf if row["high"] is None else row["high"]
    return low <= row["truth"] <= high


def _proportion(hits: int, count: int) -> tuple[float, float]:
    low = 0.0 if hits == 0 else float(beta.ppf(0.025, hits, count - hits + 1))
    high = 1.0 if hits == count else float(beta.ppf(0.975, hits + 1, count - hits))
    return low, high


@click.command()
@click.option("--sets", default=200, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), required=True)
@click.option("--workers", default=2, show_default=True)
def main(sets: int, out: Path, workers: int) -> None:
    """Runs the study, or what is left of it, and prints its figures."""
    set_up_jax()
    out.parent.mkdir(parents=True, exist_ok=True)
    lines = [json.loads(text) for text in out.read_text().splitlines()] if out.exists() else []
    left = sorted(set(range(sets)) - {line["seed"] for line in lines})
    context = multiprocessing.get_context("spawn")
    with context.Pool(workers) as pool, out.open("a") as stream:
        for line in track(pool.imap_unordered(study, left), total=len(left), description="data sets"):
            stream.write(json.dumps(line) + "\n")
            stream.flush()
            lines.append(line)
    Console().print(summary(lines))


if __name__ == "__main__":
    main()

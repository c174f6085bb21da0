"""Turns records of the base-excited single-storey frame into a data set.

The records (t_s, base_y_m, mass_x_m) belong to Marino & Cicirello 2023, arXiv 2303.03858, from which the
default constants are: a brass disc on a wall presses on the frame's top plate, all damping acts between mass
and base.

    python scripts/convert_frame.py 350g.csv 450g.csv --disc-mass 0.350 --disc-mass 0.450 --out frame
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from jaxstick.errors import UserError
from jaxstick.formats.foreign import read_foreign
from jaxstick.output import OutputFolder
from jaxstick.record import AssumedConstants, DataSet, KnownRig, Noise, Run, load_dataset, save_dataset

COLUMNS = {"time": "t_s", "base": "base_y_m", "displacement": "mass_x_m"}
GRAVITY = 9.81
CONTACT_OVER_SPRING = 50.0

COMMENT = """Base-excited single-storey frame, Marino & Cicirello 2023, arXiv 2303.03858.
Assumed: C = mu m_disc g with mu = {mu:g} where the disc's mass was given, no weakening (A = 0, so B has no
effect), no viscous part (D = 0), and k1 = 50 K, the rule of the 1987 paper; none of these was measured on
this rig."""


def convert(arguments: argparse.Namespace) -> DataSet:
    """The data set of the named files; raises UserError for files of another layout."""
    files: list[Path] = arguments.files
    discs: list[float | None] = arguments.disc_mass or [None] * len(files)
    if len(discs) != len(files):
        raise UserError(
            f"--disc-mass is given {len(discs)} times for {len(files)} files; give it once for each file."
        )
    names = [path.name for path in files]
    for name in arguments.hold_out:
        if name not in names:
            raise UserError(f"--hold-out {name} is none of the files {', '.join(names)}.")
    if len(set(names)) < len(names):
        raise UserError(f"two of the files {', '.join(names)} have the same name.")
    rig = KnownRig(
        arguments.mass,
        arguments.stiffness,
        arguments.stiffness,
        arguments.damping,
        arguments.damping,
        "ground",
    )
    assumed = AssumedConstants(A=0.0, B=100.0, D=0.0, k1=CONTACT_OVER_SPRING * rig.stiffness)
    runs = []
    for path, disc in zip(files, discs, strict=True):
        channels = read_foreign(path, COLUMNS)
        run = Run(
            file=path.name,
            time=channels["time"],
            displacement=channels["displacement"],
            base=channels["base"],
            frequency=arguments.frequency,
            hold_out=path.name in arguments.hold_out,
            rig=rig,
            assumed=assumed if disc is None else replace(assumed, C=arguments.mu * disc * GRAVITY),
        )
        runs.append(run)
    noise = Noise(displacement=arguments.noise)
    return DataSet(name=arguments.out.name, rig=rig, assumed=assumed, noise=noise, runs=tuple(runs))


def main(words: Sequence[str] | None = None) -> int:
    """Runs the command; returns its exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="IN.csv")
    parser.add_argument("--mass", type=float, default=3.0799, help="m [kg]")
    parser.add_argument("--stiffness", type=float, default=1191.0, help="K = k_d [N/m]")
    parser.add_argument("--damping", type=float, default=0.669, help="c = c_d [N s/m]")
    parser.add_argument("--frequency", type=float, default=1.0, help="of the base [Hz]")
    parser.add_argument("--mu", type=float, default=0.29, help="friction coefficient of disc and plate")
    parser.add_argument("--noise", type=float, default=3e-6, help="of the displacement, standard dev. [m]")
    parser.add_argument("--disc-mass", type=float, action="append", help="[kg], once for each file")
    parser.add_argument(
        "--hold-out", action="append", default=[], metavar="IN.csv", help="never to be fitted"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--overwrite", action="store_true")
    arguments = parser.parse_args(words)
    try:
        dataset = convert(arguments)
        with OutputFolder(arguments.out, arguments.overwrite, arguments.files) as output:
            save_dataset(dataset, output.folder, COMMENT.format(mu=arguments.mu))
            load_dataset(output.folder)
    except UserError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    print(f"{arguments.out}: {len(dataset.runs)} runs")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Turns a record of the EMPS benchmark, a motor-driven prismatic joint, into a data set.

The records (t_s, q_m, q_ref_m, force_N) and the default constants belong to Janot, Gautier & Brunot 2019,
nonlinearbenchmark.org. There is no spring: K = 0, and the motor's force is the input. Viscous friction is
friction here, so it goes to D and the rig's own damping is 0. The reference position is left out.

    python scripts/convert_emps.py emps_train.csv --out emps
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from jaxstick.errors import UserError
from jaxstick.formats.foreign import read_foreign
from jaxstick.output import OutputFolder
from jaxstick.record import AssumedConstants, DataSet, KnownRig, Run, load_dataset, save_dataset

COLUMNS = {"time": "t_s", "displacement": "q_m", "force": "force_N"}

COMMENT = """EMPS benchmark, Janot, Gautier & Brunot 2019, nonlinearbenchmark.org.
Assumed: mass, C and D as its authors identified them, no weakening (A = 0, so B has no effect); they report
an offset of the force of -3.2 N beside. k1 is not known and is left out."""


def convert(arguments: argparse.Namespace) -> DataSet:
    """The data set of the named file; raises UserError for a file of another layout."""
    rig = KnownRig(arguments.mass, 0.0, 0.0, 0.0, 0.0, "ground")
    assumed = AssumedConstants(A=0.0, B=100.0, C=arguments.coulomb, D=arguments.viscous, k1=arguments.k1)
    channels = read_foreign(arguments.file, COLUMNS)
    run = Run(
        file=arguments.file.name,
        time=channels["time"],
        displacement=channels["displacement"],
        force=channels["force"],
        rig=rig,
        assumed=assumed,
    )
    return DataSet(name=arguments.out.name, rig=rig, assumed=assumed, runs=(run,))


def main(words: Sequence[str] | None = None) -> int:
    """Runs the command; returns its exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("file", type=Path, metavar="IN.csv")
    parser.add_argument("--mass", type=float, default=95.1, help="m [kg]")
    parser.add_argument("--coulomb", type=float, default=20.4, help="assumed C [N]")
    parser.add_argument("--viscous", type=float, default=203.0, help="assumed D [N s/m]")
    parser.add_argument("--k1", type=float, help="assumed contact stiffness [N/m]")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--overwrite", action="store_true")
    arguments = parser.parse_args(words)
    try:
        dataset = convert(arguments)
        with OutputFolder(arguments.out, arguments.overwrite, [arguments.file]) as output:
            save_dataset(dataset, output.folder, COMMENT)
            load_dataset(output.folder)
    except UserError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    print(f"{arguments.out}: 1 run")
    return 0


if __name__ == "__main__":
    sys.exit(main())

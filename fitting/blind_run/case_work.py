"""What a worker does with one case; light to import, since whoever hands out the cases reads it too."""

from __future__ import annotations

import tempfile
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from fitting.diagnosis.settings import DiagnosisSettings
from fitting.progress import Silent
from jaxstick.compilation_cache import set_up_jax
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.output import to_json
from jaxstick.version import version

load_dataset = deferred("jaxstick.record", "load_dataset")
diagnose = deferred("fitting.diagnosis.diagnose", "diagnose")
diagnosis_content = deferred("fitting.diagnosis.save", "diagnosis_content")


class Outcome(NamedTuple):
    """The text of diagnosis.json, or one sentence on why there is none."""

    diagnosis: str | None
    failure: str | None


def diagnose_folder(folder: Path, seed: int) -> Outcome:
    """Diagnoses the case in a folder, on one thread; no failure leaves it."""
    set_up_jax()
    try:
        data = load_dataset(folder)
        found = diagnose(data, DiagnosisSettings(seed=seed, workers=1), Silent())
        return Outcome(to_json(diagnosis_content(found, data)), None)
    except Exception as error:
        return Outcome(None, sentence_of(error))


def diagnose_sent(name: str, files: Mapping[str, bytes], seed: int, wanted: str) -> Outcome:
    """Diagnoses a case whose files were sent along, for a worker that does not share our disk.

    Raises UserError where this process runs another version of jaxstick than `wanted`.
    """
    if version() != wanted:
        raise UserError(f"a worker of the cluster runs jaxstick {version()}, and this is {wanted}.")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / name
        for file, content in files.items():
            path = folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return diagnose_folder(folder, seed)


def sentence_of(error: Exception) -> str:
    """What went wrong, and where, in one sentence."""
    said = " ".join(str(error).split())[:300]
    if isinstance(error, UserError):
        return said
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {said} ({Path(last.filename).name}:{last.lineno})"

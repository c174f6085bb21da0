"""From which data, by which version and with which settings the report came about."""

from __future__ import annotations

from typing import Any

from fitting.report.section import Section, Subject
from fitting.report.words import listed, seconds
from jaxstick.version import version


def provenance(subject: Subject) -> Section:
    """Data set, checksum, version, settings, time taken."""
    diagnosis, dataset = subject
    held_out = [trace.file for trace in diagnosis.traces if trace.held_out]
    samples = sum(len(run.time) for run in dataset.runs)
    rows = [
        ("Data set", dataset.name),
        ("Records", f"{len(dataset.runs)} runs, {samples} samples"),
        ("Held out", listed(held_out) or "no whole run"),
        ("SHA-256 of the data", diagnosis.sha256 or "not read from files"),
        ("jaxstick", version()),
        ("Settings", ", ".join(f"{name} = {_said(value)}" for name, value in diagnosis.settings.items())),
        ("Time taken", seconds(diagnosis.seconds)),
    ]
    return Section("provenance", "Provenance", "provenance.html", {"rows": rows})


def _said(value: Any) -> str:
    if isinstance(value, list | tuple):
        return listed([str(part) for part in value]) or "none"
    return str(value)

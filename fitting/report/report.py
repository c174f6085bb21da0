"""The page: all sections in their order, one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import jinja2
from markupsafe import Markup

from fitting.diagnosis.findings import Diagnosis
from fitting.progress import Progress
from fitting.report.section import Section, Subject
from fitting.report.sections.account import account
from fitting.report.sections.cards import cards
from fitting.report.sections.constants import constants
from fitting.report.sections.how_far import how_far
from fitting.report.sections.provenance import provenance
from fitting.report.sections.summary import summary
from fitting.report.sections.traces import traces
from fitting.report.sections.where import where
from fitting.report.sections.which import which
from fitting.report.words import VERDICTS, in_parts, tied
from jaxstick.output import OutputFolder
from jaxstick.record import DataSet

REPORT_FILE = "report.html"
SECTIONS: tuple[Callable[[Subject], Section | None], ...] = (
    summary,
    traces,
    where,
    which,
    how_far,
    constants,
    cards,
    account,
    provenance,
)

_TEMPLATES = Path(__file__).parent / "templates"


def write_report(diagnosis: Diagnosis, dataset: DataSet, output: OutputFolder, progress: Progress) -> None:
    """Writes report.html into the folder."""
    output.write_text(REPORT_FILE, report(diagnosis, dataset, progress))


def report(diagnosis: Diagnosis, dataset: DataSet, progress: Progress) -> str:
    """The page as text. Whatever comes from the data, file names too, is escaped."""
    progress.stage("report", len(SECTIONS))
    sections = []
    for make in SECTIONS:
        section = make(Subject(diagnosis, dataset))
        if section is not None:
            sections.append(section)
        progress.advance(make.__name__.replace("_", " "))
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=lambda value: tied(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["in_parts"] = in_parts
    return environment.get_template("page.html").render(
        name=dataset.name,
        sentence=diagnosis.sentence,
        verdict=VERDICTS[diagnosis.verdict],
        verdict_key=diagnosis.verdict,
        sections=sections,
        look=Markup((_TEMPLATES / "look.css").read_text(encoding="utf-8")),
    )

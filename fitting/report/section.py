"""What a section of the report is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from markupsafe import Markup

from fitting.diagnosis.findings import Diagnosis
from jaxstick.record import DataSet


class Subject(NamedTuple):
    """What a report is about: the diagnosis and the data set it is of."""

    diagnosis: Diagnosis
    dataset: DataSet


class Section(NamedTuple):
    """A part of the page: `key` is its anchor, `template` a file in templates/, `content` what fills it."""

    key: str
    title: str
    template: str
    content: Mapping[str, Any]


class Bar(NamedTuple):
    """One bar of a bar chart: its length is a share of one; a strong one is what the reader should see."""

    label: str
    text: str
    length: float
    strong: bool = False
    hint: str = ""


class Picture(NamedTuple):
    """A drawn figure with the heading that says what one sees."""

    title: str
    svg: Markup


class Number(NamedTuple):
    """A value with its interval in words."""

    value: str
    interval: str = ""

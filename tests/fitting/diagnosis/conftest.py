"""One made-up diagnosis, its report, and a browser to look at it, for all tests here."""

from __future__ import annotations

from pathlib import Path

import pytest

from fitting.diagnosis.findings import Diagnosis
from fitting.progress import Silent
from fitting.report.report import report
from jaxstick.record import DataSet
from tests.fitting.diagnosis.chromium import Chromium, browser
from tests.fitting.diagnosis.fabricated import fabricated


@pytest.fixture(scope="session")
def made_up() -> tuple[Diagnosis, DataSet]:
    """The diagnosis and its data set."""
    return fabricated(cycles=2.2, rate=250.0)


@pytest.fixture(scope="session")
def diagnosis(made_up) -> Diagnosis:
    """The diagnosis alone."""
    return made_up[0]


@pytest.fixture(scope="session")
def dataset(made_up) -> DataSet:
    """The data set alone."""
    return made_up[1]


@pytest.fixture(scope="session")
def page(diagnosis, dataset) -> str:
    """The report."""
    return report(diagnosis, dataset, Silent())


@pytest.fixture(scope="session")
def page_file(page, tmp_path_factory) -> Path:
    """The report in a folder of its own."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A headless browser; tests that want one are skipped where there is none."""
    program = browser()
    if program is None:
        pytest.skip("no Chromium or Chrome on this machine")
    with Chromium(program, tmp_path_factory.mktemp("profile")) as running:
        yield running

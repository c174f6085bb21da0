"""How the verdict was reached, and what weakens it."""

from __future__ import annotations

from fitting.report.section import Section, Subject


def account(subject: Subject) -> Section:
    """Steps in their order, and notes."""
    diagnosis = subject.diagnosis
    content = {"steps": diagnosis.steps, "notes": diagnosis.notes}
    return Section("account", "How the verdict was reached", "account.html", content)

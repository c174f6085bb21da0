"""The cards of the effects: the named ones open, the others folded."""

from __future__ import annotations

from fitting.report.section import Section, Subject


def cards(subject: Subject) -> Section | None:
    """What the named effects are and what to do about them; None where there is no card to show."""
    diagnosis = subject.diagnosis
    if not diagnosis.cards:
        return None
    named = [(key, diagnosis.cards[key]) for key in diagnosis.named if key in diagnosis.cards]
    others = [(key, card) for key, card in diagnosis.cards.items() if key not in diagnosis.named]
    title = "Effects considered"
    if named:
        title = "The named effect" if len(named) == 1 else "The named effects"
    if diagnosis.verdict == "ambiguous":
        title = "What it may be"
    return Section("cards", title, "cards.html", {"named": named, "others": others})

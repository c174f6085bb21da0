"""The cards of the effects: the named ones open, the others folded."""

from __future__ import annotations

from fitting.report.section import Section, Subject

CONSIDERED = 4
"""Besides what is named, the effects of so many of the likeliest explanations have been considered."""


def cards(subject: Subject) -> Section | None:
    """What the named effects are and what to do about them; None where there is no card to show."""
    diagnosis = subject.diagnosis
    likeliest = [key for candidate in diagnosis.candidates[:CONSIDERED] for key in candidate.keys]
    shown = [key for key in dict.fromkeys((*diagnosis.named, *likeliest)) if key in diagnosis.cards]
    if not shown:
        return None
    named = [(key, diagnosis.cards[key]) for key in shown if key in diagnosis.named]
    others = [(key, diagnosis.cards[key]) for key in shown if key not in diagnosis.named]
    title = "Effects considered"
    if named:
        title = "The named effect" if len(named) == 1 else "The named effects"
    if diagnosis.verdict == "ambiguous":
        title = "What it may be"
    return Section("cards", title, "cards.html", {"named": named, "others": others})

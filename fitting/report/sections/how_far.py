"""How far the gap closes on what took no part, and the named effects in numbers."""

from __future__ import annotations

from fitting.corrected_rig import CORRECTED_FILE
from fitting.diagnosis.findings import Diagnosis
from fitting.diagnosis.save import closed_by
from fitting.report.section import Section, Subject
from fitting.report.sections.which import parameter_number
from fitting.report.words import is_number, listed, number, percent, share_interval, title


def how_far(subject: Subject) -> Section:
    """The gap in each state, the share closed beside what an empty and a wrong effect close, parameters."""
    diagnosis, closure = subject.diagnosis, subject.diagnosis.closure
    gaps = [
        ("Assumed constants", closure.assumed),
        ("Nominal model, fitted", closure.before),
        ("With the named effects, fitted", closure.after if diagnosis.effects else None),
        ("Noise alone", closure.floor),
    ]
    closed = [
        ("Named effects", closure.closed if diagnosis.effects else None, share_interval(*closure.interval)),
        (_not_named(diagnosis), closure.wrong, ""),
        ("Placebo: an effect of no meaning", closure.placebo, ""),
    ]
    content = {
        "gaps": [(label, number(value)) for label, value in gaps if value is not None and is_number(value)],
        "closed": [
            (label, percent(value), bounds)
            for label, value, bounds in closed
            if value is not None and is_number(value)
        ],
        "corrected_rig": CORRECTED_FILE if diagnosis.correction is not None else "",
        "judged_on": listed(closure.held_out),
        "by_segments": closure.by_segments,
        "effects": [
            {
                "title": title(key, diagnosis.cards),
                "key": key,
                "closed": percent(closed_by(diagnosis, key)),
                "parameters": [(found.name, parameter_number(found)) for found in parameters],
            }
            for key, parameters in diagnosis.effects.items()
        ],
    }
    return Section("how-far", "How far the gap closes", "how_far.html", content)


def _not_named(diagnosis: Diagnosis) -> str:
    titles = " and ".join(title(key, diagnosis.cards) for key in diagnosis.closure.wrong_keys)
    return f"Best that was not named{': ' if titles else ''}{titles}"

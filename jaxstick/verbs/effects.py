"""jaxstick effects: the shelf of candidate explanations."""

import dataclasses
from typing import Any

import click

from jaxstick.command import common
from jaxstick.deferred import deferred
from jaxstick.terminal import Terminal

catalogue = deferred("jaxstick.catalogue", "catalogue")
effects_at_null = deferred("jaxstick.hypothesis", "effects_at_null")
parameters = deferred("jaxstick.parameter", "parameters")


@click.command()
@click.argument("key", required=False)
@common
def effects(key: str | None, terminal: Terminal) -> None:
    """List the effects that a fit can take into account, or show the card of the one called KEY."""
    if key is None:
        shelf = {name: _described(name, effect()) for name, effect in catalogue().items()}
        shelf = dict(sorted(shelf.items(), key=lambda item: (item[1]["family"], item[0])))
        terminal.table(
            f"{len(shelf)} effects",
            ("key", "concerns", "what it is", "strength"),
            [(name, card["family"], card["title"], _strength(card)) for name, card in shelf.items()],
        )
        terminal.say("jaxstick effects KEY shows symptom, explanation, remedy and source of one.")
        terminal.result({"schema": 1, "effects": shelf})
        return
    card = _described(key, effects_at_null((key,))[key])
    terminal.say(f"{card['title']} ({key})", "bold")
    for part in ("symptom", "explanation", "remedy", "source"):
        terminal.say(f"{part.capitalize()}: {card[part]}")
    terminal.table(
        "Parameters",
        ("name", "unit", "meaning", "no influence at"),
        [
            (
                entry["name"],
                entry["unit"],
                entry["meaning"],
                "-" if entry["null"] is None else f"{entry['null']:g}",
            )
            for entry in card["parameters"]
        ],
    )
    terminal.result({"schema": 1, "effects": {key: card}})


def _described(key: str, effect: Any) -> dict[str, Any]:
    places = [{"name": place.path[-1], **dataclasses.asdict(place.parameter)} for place in parameters(effect)]
    return {"key": key, **dataclasses.asdict(effect.card), "parameters": places}


def _strength(card: dict[str, Any]) -> str:
    first = card["parameters"][0]
    return first["name"] if first["unit"] == "1" else f"{first['name']} [{first['unit']}]"

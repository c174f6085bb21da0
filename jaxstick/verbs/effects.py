"""jaxstick effects: the shelf of candidate explanations."""

import dataclasses
from pathlib import Path
from typing import Any

import click

from jaxstick.command import common
from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.output import OutputFolder
from jaxstick.terminal import Terminal

catalogue = deferred("jaxstick.catalogue", "catalogue")
effects_at_null = deferred("jaxstick.hypothesis", "effects_at_null")
parameters = deferred("jaxstick.parameter", "parameters")
signature = deferred("jaxstick.signature", "signature")
draw_signature = deferred("jaxstick.plots.signature", "draw_signature")
save_figure = deferred("jaxstick.plots.style", "save")


@click.command()
@click.argument("key", required=False)
@click.option(
    "--out",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for the card of KEY and a picture of its signature on a nominal rig.",
)
@click.option("--overwrite", is_flag=True, help="Replace earlier results of jaxstick in DIR.")
@common
def effects(key: str | None, out: Path | None, overwrite: bool, terminal: Terminal) -> None:
    """List the effects that a fit can take into account, or show the card of the one called KEY."""
    if key is None:
        if out is not None:
            raise UserError("--out draws one effect; name it, as in jaxstick effects KEY --out DIR.")
        _show_shelf(terminal)
        return
    card = _described(key, effects_at_null((key,))[key])
    result = {"schema": 1, "effects": {key: card}}
    if out is not None:
        with OutputFolder(out, overwrite) as output:
            save_figure(draw_signature(signature(key)), output.path(f"{key}.png"))
            output.write_json(f"{key}.json", result)
    _show_card(key, card, terminal)
    if out is not None:
        terminal.say(f"Its signature on a nominal rig is drawn in {out / key}.png.")
    terminal.result(result)


def _show_shelf(terminal: Terminal) -> None:
    shelf = {name: _described(name, effect()) for name, effect in catalogue().items()}
    shelf = dict(sorted(shelf.items(), key=lambda item: (item[1]["family"], item[0])))
    terminal.table(
        f"{len(shelf)} effects",
        ("key", "concerns", "what it is", "strength"),
        [(name, card["family"], card["title"], _strength(card)) for name, card in shelf.items()],
    )
    terminal.say("jaxstick effects KEY shows symptom, explanation, remedy and source of one.")
    terminal.result({"schema": 1, "effects": shelf})


def _show_card(key: str, card: dict[str, Any], terminal: Terminal) -> None:
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


def _described(key: str, effect: Any) -> dict[str, Any]:
    places = [{"name": place.path[-1], **dataclasses.asdict(place.parameter)} for place in parameters(effect)]
    return {"key": key, **dataclasses.asdict(effect.card), "parameters": places}


def _strength(card: dict[str, Any]) -> str:
    first = card["parameters"][0]
    return first["name"] if first["unit"] == "1" else f"{first['name']} [{first['unit']}]"

"""Numbers and names as the report and the terminal write them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from markupsafe import Markup

from fitting.against import figures
from jaxstick.effect import Card

NOTHING = "-"
"""What a cell without a number shows."""
NONE, UNLISTED = "none", "unlisted"

VERDICTS = {
    "none": "No gap beyond the noise",
    "effect": "One effect named",
    "several": "Several effects together",
    "ambiguous": "These records cannot tell which",
    "unlisted": "None of the listed effects",
}


def is_number(value: float | None) -> bool:
    """Whether there is a finite number."""
    return value is not None and math.isfinite(value)


def percent(share: float | None) -> str:
    """A share of one: '93 %', '0.4 %', '< 0.1 %'."""
    if share is None or not math.isfinite(share):
        return NOTHING
    if 0 < share < 0.001:
        return "< 0.1 %"
    if 0.999 < share < 1:
        return "> 99.9 %"
    hundredths = 100 * share
    return (
        f"{hundredths:.1f} %"
        if 0 < abs(hundredths) < 9.95 or 99 < hundredths < 100
        else f"{hundredths:.0f} %"
    )


def number(value: float | None, kept: int = 3) -> str:
    """A number to so many figures."""
    if value is None or not math.isfinite(value):
        return NOTHING
    return f"{value:#.{kept}g}".rstrip(".") if abs(value) < 10**kept else f"{value:.0f}"


def estimate(value: float | None, low: float | None, high: float | None) -> str:
    """A value with two figures of its interval; to two figures where there is none."""
    width = spread(value, low, high)
    return number(value, 2) if width is None else figures(value, width)


def interval(value: float | None, low: float | None, high: float | None) -> str:
    """'1.02 to 1.08', 'up to 3', or that the records do not bound it."""
    width = spread(value, low, high)
    if is_number(low) and is_number(high):
        return f"{figures(low, width)} to {figures(high, width)}"
    if is_number(high):
        return f"up to {figures(high, width)}"
    if is_number(low):
        return f"from {figures(low, width)}"
    return "not bounded"


def share_interval(low: float, high: float) -> str:
    """'97.1 % to 99.4 %'; empty where there is none."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return ""
    return f"{100 * low:.3g} to {100 * high:.3g} %"


def spread(value: float | None, low: float | None, high: float | None) -> float | None:
    """The distance of the value to the nearer end that it does not sit on."""
    if value is None:
        return None
    ends = [abs(end - value) for end in (low, high) if end is not None and math.isfinite(end)]
    return min((end for end in ends if end), default=None)


def with_unit(text: str, unit: str) -> str:
    """The number with its unit; a dimensionless one has none."""
    bare = unit in ("1", "") or text in (NOTHING, "not bounded")
    return text if bare else f"{text} {unit.replace('^2', '²').replace('^3', '³')}"


def title(key: str, cards: Mapping[str, Card]) -> str:
    """What an explanation is called: its card's title, words for none and unlisted, else the key in words."""
    if key in cards:
        return cards[key].title
    return {NONE: "Nothing beyond the noise", UNLISTED: "Something not on the list"}.get(
        key, key.replace("_", " ").capitalize()
    )


def harmonic(order: str) -> str:
    """'0' is the mean, '1' the drive's frequency, '3' the third harmonic."""
    if order == "0":
        return "mean"
    return f"order {order}" if order.isdigit() else order


def seconds(duration: float) -> str:
    """'41.7 s' or '3 min 5 s'."""
    if duration < 99.5:
        return f"{duration:.3g} s"
    minutes, rest = divmod(round(duration), 60)
    return f"{minutes} min {rest} s"


def listed(names: Sequence[str]) -> str:
    """'a', 'a and b', 'a, b and c'."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def largest(shares: Mapping[str, float]) -> tuple[str, float] | None:
    """The name with the largest share; None of none."""
    return max(shares.items(), key=lambda item: item[1]) if shares else None


def ranked(shares: Mapping[str, float], most: int) -> list[tuple[str, float]]:
    """The largest shares, the largest first."""
    return sorted(shares.items(), key=lambda item: -item[1])[:most]


def clamped(share: float | None) -> float:
    """A share as the length of a bar, between 0 and 1."""
    return min(max(share, 0.0), 1.0) if share is not None and math.isfinite(share) else 0.0


def tied(text: str) -> str:
    """The text with numbers tied to their per cent signs, so that no line ends between them."""
    return text.replace(" %", "\N{NO-BREAK SPACE}%")


def in_parts(name: str) -> Markup:
    """The name of an effect or parameter as markup in which a line may end behind every underscore."""
    return Markup("_<wbr>").join(name.split("_"))


def greatest(values: Iterable[float | None]) -> float:
    """The largest of the numbers there are; 0 of none."""
    return max((value for value in values if value is not None and math.isfinite(value)), default=0.0)

"""Pieces of the sentences a UserError is made of."""

import difflib
from collections.abc import Iterable


def shown(text: object, limit: int = 40) -> str:
    """`text` quoted on one line, control characters escaped, clipped to `limit` characters."""
    plain = str(text)
    return repr(plain if len(plain) <= limit else plain[: limit - 3] + "...")


def did_you_mean(word: str, known: Iterable[str], after: str = "") -> str:
    """' (did you mean X?)' for the known word nearest to `word`, or an empty string if none is near.

    after: what follows X inside the question.
    """
    spelt = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word.lower(), list(spelt), n=1, cutoff=0.75)
    return f" (did you mean {spelt[near[0]]}{after}?)" if near else ""


def listed(words: Iterable[str]) -> str:
    """'a', 'a or b', 'a, b or c'."""
    items = list(words)
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} or {items[-1]}"

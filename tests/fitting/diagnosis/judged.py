"""Accounts to be judged, of effects on a made-up shelf."""

from __future__ import annotations

from fitting.diagnosis.accounts import Account

SHELF = [f"effect_{n}" for n in range(36)]
SAMPLES = 16000.0


def account(number: int, misfit: float, parameters: int = 1) -> Account:
    return Account((SHELF[number],), misfit, parameters)


def both(misfit: float) -> Account:
    """The first two together."""
    return Account((SHELF[0], SHELF[1]), misfit, 2)

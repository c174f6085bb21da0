"""What steadier friction is worth to an explanation."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fitting.diagnosis.accounts import Account

NEARLY_BEST = 1.15
NO_WORSE = 1.005
"""What steadier friction is worth counts for explanations that leave no more than so many times the least,
and than so many times what none leaves: the search for one that leaves more has ended elsewhere."""
AS_LITTLE = 1.01
"""Two effects leave no more than the better of them alone where they leave less than so many times that: with
friction that wanders less they may end in a fit that costs a little more."""
ALIKE = 1.001
"""What leaves less than so many times as much leaves no more: a hum whose third harmonic comes back at every
third sample is an offset, and did so by a hundred-thousandth."""
MENDS = 0.4
"""By such a share of what the first effect does for it a second one makes friction steadier that mends the
shape of the first: of two sealed cases that had one effect it did by 0.28 and 0.29 of it, of one that had
two by 2."""
BOTH = 0.5
"""The share that counts of what friction is steadier under two effects beyond that, where the second changes
friction itself."""


def credited(accounts: Sequence[Account], nominal: float) -> dict[tuple[str, ...], float]:
    """What steadier friction is worth to every account: nothing where it leaves far more than the best, for
    what is left bends levels, or more than none does; to two effects as much as to the better of them alone,
    but not to one that leaves far more and does not change friction itself, and a share of what is well
    beyond that where they leave no more than one and the second changes friction, but all of it where that
    one alone of the two changes along the runs, which mends no shape; to what leaves no more and
    makes friction no less steady than another of as many effects, no less than to that; and to an effect that
    leaves more, as much as to two of which it is one, for that does not tell it from them.
    """
    singles = [account for account in accounts if len(account.keys) == 1]
    alone = {account.keys[0]: account.steadier for account in singles}
    left = {account.keys[0]: account.misfit for account in singles}
    least = min(left.values(), default=math.inf)
    best = min([nominal, *(account.misfit for account in accounts)])
    most = min(NEARLY_BEST * best, NO_WORSE * nominal)

    def worth(account: Account) -> float:
        second = max(account.keys, key=lambda key: left.get(key, math.inf))
        bent = second not in account.of_friction and left.get(second, math.inf) > most
        better = max(alone.get(k, 0.0) for k in account.keys if k != second or not bent)
        counts = second in account.of_friction and account.misfit <= AS_LITTLE * least
        if counts and {*account.changing} == {second}:
            return account.steadier
        beyond = max(account.steadier - (1 + MENDS) * better, 0.0) if counts else 0.0
        return min(account.steadier, better) + BOTH * beyond

    close = [account for account in accounts if account.misfit <= most]
    plain = {account.keys: worth(account) for account in close}
    near = {one.keys: max(plain[other.keys] for other in close if _does_no_less(one, other)) for one in close}
    part = {
        (key,): min(steadier, max((near[keys] for keys in near if key in keys), default=0.0))
        for key, steadier in alone.items()
    }
    return {account.keys: 0.0 for account in accounts} | part | near


def _does_no_less(one: Account, other: Account) -> bool:
    """Whether an explanation leaves no more than another of as many effects, and makes friction as steady."""
    alike = len(one.keys) == len(other.keys)
    return alike and one.misfit <= ALIKE * other.misfit and one.steadier >= other.steadier

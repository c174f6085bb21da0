"""From misfits to probabilities and a verdict.

Every explanation j leaves a misfit m_j (chi-square per degree of freedom). With the level of the noise
unknown its logarithmic likelihood is -(N/2) log m_j, and -(k_j/2) log N pays for its parameters (Schwarz,
Annals of Statistics 6 (1978) 461). N is not the number of samples: residuals are correlated, and where even
the best explanation leaves something, what is left is a bias that more samples do not average out.

The constants below are rounded from fits by the logarithmic score to sealed cases, 75 of the purpose
"calibration" first and 135 of three full blind runs since; around them the score is flat. What "unlisted" is
taken to leave and cost was set from what right effects, and wrong ones in the place of an effect off the
shelf, left in other sealed cases, `LEAST_INFLATION` from one without any.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from fitting.diagnosis.accounts import Account
from fitting.diagnosis.judging.credit import credited
from fitting.diagnosis.judging.enough import NOISE_KNOWN
from fitting.diagnosis.judging.judgement import DOUBT, Judgement, judged, reserve
from fitting.diagnosis.judging.lead import lead
from fitting.diagnosis.judging.one_class import Classes
from fitting.diagnosis.judging.second import Alone
from fitting.diagnosis.judging.single import AMONG, Single, singly
from fitting.diagnosis.judging.verdict import NONE, UNLISTED
from fitting.diagnosis.judging.whiteness import whiteness

MISSPECIFIED = 12.0
"""How many independent pieces of evidence are left where the best explanation leaves a misfit of 2."""
LEAST_PIECES = 14.0
NESTED = 1.7
"""So many times as many where two effects are compared with one of the two: what that one's shape lacks is in
both and tells them apart no less."""
LEAST_INFLATION = 3.0
"""Scores vary at least so many times as much as white noise says: the integrator's own error sees to that."""
FLOOR = 0.1
"""How far above the noise the nominal model may stay where nothing else acts: the noise is estimated,
and sensors and sampling have ways of their own. Of 396 sealed cases without an effect and without scatter one
in ten left 0.05 and more, one in a hundred 0.16 and more."""
ALIKE = 0.05
"""Aliases whose misfits differ by less than this share of the excess are not told apart."""
SOFT = 0.03
"""Differences of misfits count against this share of the excess besides the misfits themselves: so much may
depend on the shape that an effect has on the shelf."""
UNLISTED_SHARE = 0.25
"""The share of the excess that an effect off the shelf is taken to leave: a listed one that leaves far more
is not the cause. In 121 sealed cases with an excess of a half and more the right effect left more than 0.27
of it twice, and 0.14 to 0.26 of it six times, being of other forms than on the shelf; in the place of one
off the shelf the best listed one left 0.39 and more of it in 17 of 17."""
LACKING = 0.15
"""An effect off the shelf is taken to make friction steadier by all but this share of what the best does
alone that is listed, too, and by no less than that where the best explanation leaves more of the excess."""
UNLISTED_FLOOR = (1.1, 1.4), (1.1, 1.0)
"""Misfits of the nominal model between which what is off the shelf is asked to explain nothing of the first
tenth above the noise, and then all: so close to the noise there may be nothing."""
UNLISTED_PARAMETERS = 1
"""Its strength."""
EXPLAINS = 0.5, 0.2
"""What an effect off the shelf may be taken to do for the steadiness of friction is what a listed one does
that leaves less than this share of the excess, or no more than so much above the noise."""
PRIOR = {"none": 0.3, "unlisted": 0.08, "single": 0.5, "pair": 0.12}
HIDDEN, HIDDEN_ON_SHELF = 0.06, 0.1
"""Where friction scatters, so much of what is likely of "none" is so of something off the shelf that the
scatter hides, and of an effect that changes friction: of 224 cases called "none" so in five sealed sets, 178
had no effect, 21 one off the shelf, 21 one that changes friction and four another one; with a larger shelf,
of 55 in three sets, 48, two, three and two."""
TAKEN_FOR = 0.2
"""So much, and less the more there is to explain, of what is likely of an effect is so of something off the
shelf where friction scatters: with an excess of less than 0.4, five of 34 named had been so; with a larger
shelf, of 77 with any excess, one."""


def judge(
    nominal: float,
    accounts: Sequence[Account],
    samples: float,
    inflation: float,
    shelf: Sequence[str],
    aliases: Mapping[str, Collection[str]] | None = None,
    classes: Classes | None = None,
    *,
    hidden: Collection[str] = (),
    collinear: Mapping[str, Collection[str]] | None = None,
) -> Judgement:
    """The probabilities of all explanations. Where the best of them leaves less than the noise is said to be,
    the noise is what that one leaves.

    nominal: the misfit without any effect; samples: degrees of freedom; inflation: variance of scores by
    clusters over that of white residuals; shelf: all keys; aliases: effects that these records do not tell
    from an effect; classes: what no records do; hidden: where friction scatters, the effects that this hides
    more than others; collinear: effects whose traces in these records are nearly collinear with an effect's.
    """
    best = min([nominal, *(account.misfit for account in accounts)])
    noise = min(best, 1.0)
    accounts = [dataclasses.replace(account, misfit=account.misfit / noise) for account in accounts]
    nominal, best = nominal / noise, best / noise
    pieces = pieces_of_evidence(best, samples, inflation)
    among = pieces_of_evidence(best, samples, AMONG)
    surely = pieces_of_evidence(max(best - NOISE_KNOWN, 1.0), samples, inflation)
    excess = max(nominal - 1.0, 0.0)
    same = _alike(aliases or {}, classes or {})
    alone = Alone.of(accounts, nominal, same, collinear or {})

    def beyond_one(misfit: float, soft: float, pieces: float) -> float:
        one, this = (math.log(max(left, 1e-3) + soft) for left in (alone.best, misfit))
        return 0.5 * pieces * (one - this)

    def weight(price: float, prior: float) -> float:
        return math.log(prior) - price

    def behind(misfit: float, pieces: float) -> float:
        return -beyond_one(misfit, SOFT * excess, pieces)

    floor = float(np.interp(nominal, *UNLISTED_FLOOR))
    unlisted = floor + UNLISTED_SHARE * max(nominal - floor, 0.0)
    names = [NONE, UNLISTED]
    steady = credited(accounts, nominal)
    anything = Account((), unlisted, UNLISTED_PARAMETERS)
    lacking = 0.0 if best > floor + LACKING * max(nominal - floor, 0.0) else LACKING
    steady[anything.keys] = (1 - lacking) * _steadiest(accounts, steady, excess)
    against = lead(alone.misfits, nominal, same) + whiteness(nominal, inflation)
    logs = [
        weight(0.0, PRIOR[NONE]) - behind(nominal, surely) - 0.5 * (excess / FLOOR) ** 2,
        weight(anything.price(pieces) - steady[anything.keys] + against, PRIOR[UNLISTED])
        - behind(unlisted, surely),
    ]
    prices = {account.keys: account.price(pieces) - steady[account.keys] for account in accounts}
    singles = singly(
        {
            account.keys: Single(
                prices[account.keys],
                behind(account.misfit, surely),
                behind(account.misfit, among),
                account.price(pieces) - account.price(among),
            )
            for account in accounts
            if len(account.keys) == 1
        },
        behind(nominal, surely),
    )
    pairs = max(len(shelf) * (len(shelf) - 1) / 2, 1)
    for account in accounts:
        names.append("+".join(account.keys))
        if account.keys in singles:
            logs.append(weight(0.0, PRIOR["single"] / len(shelf)) + singles[account.keys])
            continue
        more = NESTED * beyond_one(account.misfit, alone.soft, pieces)
        more = min(more, 0.0) if alone.makes_needless(account) else more
        logs.append(weight(prices[account.keys], PRIOR["pair"] / pairs) + more)
    logs = _levelled(names, logs, accounts, ALIKE * excess, aliases or {})
    untried = [key for key in shelf if (key,) not in steady]
    names, logs = [*names, *untried], [*logs, *[-math.inf] * len(untried)]
    share = np.exp(np.array(logs) - max(logs))
    kept = reserve(names)
    explanations = {
        name: kept[name] + (1 - DOUBT) * part
        for name, part in zip(names, (share / share.sum()).tolist(), strict=True)
    }
    if hidden:
        explanations = _doubted(explanations, excess, hidden)
    return judged(explanations, [NONE, UNLISTED, *shelf], steady, classes or {})


def _steadiest(accounts: Sequence[Account], steady: Mapping[tuple[str, ...], float], excess: float) -> float:
    """What steadier friction is worth to the one of the listed effects to which it is worth most; of those
    that explain a good part of the excess, where there are such."""
    singles = [account for account in accounts if len(account.keys) == 1]
    share, little = EXPLAINS
    good = [one for one in singles if one.misfit < 1 + max(share * excess, little)]
    return max((steady[one.keys] for one in good or singles), default=0.0)


def _alike(aliases: Mapping[str, Collection[str]], classes: Classes) -> dict[str, frozenset[str]]:
    """The effects that these records, or any, do not tell from an effect."""
    alone = {keys[0]: others for keys, others in classes.items() if len(keys) == 1}
    return {key: frozenset((*aliases.get(key, ()), *alone.get(key, ()))) for key in {*aliases, *alone}}


def _doubted(explanations: Mapping[str, float], excess: float, hidden: Collection[str]) -> dict[str, float]:
    """The probabilities where scatter hides a good deal."""
    mistaken = TAKEN_FOR * math.exp(-excess)
    none = explanations[NONE]
    out = {name: (1 - mistaken) * p for name, p in explanations.items() if name not in (NONE, UNLISTED)}
    for key in hidden:
        out[key] += HIDDEN_ON_SHELF * none / len(hidden)
    out[NONE] = (1 - HIDDEN - HIDDEN_ON_SHELF) * none
    out[UNLISTED] = 1 - sum(out.values())
    return {name: out[name] for name in explanations}


def _levelled(
    names: Sequence[str],
    logs: Sequence[float],
    accounts: Sequence[Account],
    difference: float,
    aliases: Mapping[str, Collection[str]],
) -> list[float]:
    """The weights, those of explanations that differ by aliases and explain the records alike shared equally
    among them."""
    misfit = {frozenset(account.keys): account.misfit for account in accounts}
    weight = {frozenset(name.split("+")): log for name, log in zip(names, logs, strict=True)}
    out = []
    for keys, log in weight.items():
        mates = {
            other
            for key in keys
            for alias in aliases.get(key, ())
            if (other := keys - {key} | {alias}) in misfit
            and len(other) == len(keys)
            and abs(misfit[other] - misfit[keys]) < difference
        }
        same = [log, *(weight[other] for other in mates)]
        out.append(float(np.logaddexp.reduce(same)) - math.log(len(same)))
    return out


def pieces_of_evidence(best: float, samples: float, inflation: float) -> float:
    """The number of independent samples that the residuals amount to."""
    correlated = max(inflation, LEAST_INFLATION) / samples
    return max(LEAST_PIECES, 1 / (correlated + max(best - 1.0, 0.0) / MISSPECIFIED))

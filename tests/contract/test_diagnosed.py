"""Each effect in each experiment at twice the smallest size that matters: named, sized, worth it.

The sizes are those of `tests.contract.hiding`. The simulator is the library's own: the blind bench
hides other implementations. What has no graded size (a stuck channel, a wrong unit) is looked for
among the raw data by `check` and is no part of this.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass

import pytest
from scipy import stats

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.diagnosis.answer import EffectStatus, Verdict
from footcal_cli.core.diagnosis.gain import main_gain
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Scope, can_carry
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.signatures import SWITCHES
from footcal_cli.intake.cases.shared import OF_CELLS
from tests.contract.hiding import SHAPES, Seen, clean, diagnosed, sized
from tests.contract.wiring import wiring
from tests.contract.worlds import WORLDS, Hidden

SEEDS = (1,)
FAINT = 0.3
"""Visible part over noise (RMS) below which silence is no miss: less is seen in too few logs."""
LEAST_P = 0.01
"""Of as many intervals without the size, were each to hold it in 95 of 100 logs."""
RAW = frozenset(
    {"channel_stuck", "channel_duplicate", "quantisation", "dropped_samples", "wrong_unit"}
)
"""Without a graded size: looked for among the raw data."""
CASES = [
    (experiment, effect)
    for experiment, world in WORLDS.items()
    for effect in TABLE.values()
    if experiment in effect.experiments
    and effect.name not in (*RAW, *world.experiment.calibration)
    and can_carry(world.channels, effect)
    and world.untested.get(effect.name) != OF_CELLS
]
KNOWN_MISSES: Mapping[tuple[str, str], str] = {
    ("walk", "saturation"): "unknown, nearest saturation: a third of the noise, in few rows",
    ("walk", "load_bypass"): "named at a third of the noise; of a choice made anew without each "
    "block no sure gain is left",
    ("stand", "saturation"): "unknown: a seventh of the noise, in few rows of few stances",
    (
        "weights",
        "bias_drift",
    ): "{temperature_bias, bias_drift} by p 1e-18; of seven sessions of one "
    "cell the first and the last hold nearly all of the gain, which so few do not make sure",
    ("stand", "bias_jump"): "among those that describe it alike, with a gain that is not sure",
}
"""Experiment and effect -> why it is missed today: a new miss fails, a repaired one is told."""
ANOTHER_SHAPE = frozenset({("placements", "saturation")})
"""A hard stop that few readings reach, between the loads at which one is looked for: what is found
is a soft one that begins earlier, and the interval is that of its size."""


@dataclass(frozen=True)
class Answer:
    """What `diagnose` said of a hidden effect, judged.

    Parameters
    ----------
    outcome
        ``ok``, ``faint`` (silent, and too small for this noise), ``not testable`` or ``MISS``.
    covered
        Whether the 95 % interval of its size holds the truth; None where there is none to compare.
    line
        Everything in one line.
    """

    outcome: str
    covered: bool | None
    line: str


ANSWERS: dict[tuple[str, str, int], Answer] = {}


def answer(experiment: str, effect: Effect, seed: int) -> Answer:
    """Hide an effect, diagnose, judge, print."""
    began = time.perf_counter()
    world = WORLDS[experiment]
    hidden, shown = sized(experiment, effect, seed)
    case = world.case(world.record(hidden, seed, True), seed)
    size = next(p for p in effect.sizes if p.name == hidden.parameter)
    told = [
        f"{experiment:<10} {effect.name:<18} {hidden.size:9.4g} {size.unit:<5}",
        f"{shown.matters:5.2f} x what matters, rho {shown.rho:6.3f}, visible {shown.fraction:4.0%}",
    ]
    findings = wiring(case) if effect.name in SWITCHES else []
    if findings:
        right = all(name in findings[0].where for name in _switched(experiment, hidden))
        outcome, covered = ("ok" if right else "MISS"), None
        told.append(f"bad-data      {findings[0].code} of {findings[0].where}")
    else:
        found = diagnosed(experiment, case, seed)
        outcome, covered = _judged(experiment, hidden, shown, found, seed, told)
    if (experiment, effect.name) in KNOWN_MISSES:
        outcome += " (known miss)" if outcome == "MISS" else " (repaired)"
    told += [f"{time.perf_counter() - began:.0f} s", outcome]
    line = "  ".join(told)
    sys.stdout.write(f"\n{line}\n")
    judged = Answer(outcome.split(" (")[0], covered, line)
    ANSWERS[experiment, effect.name, seed] = judged
    return judged


def _judged(
    experiment: str, hidden: Hidden, shown: Seen, found: Investigation, seed: int, told: list[str]
) -> tuple[str, bool | None]:
    """Outcome and coverage; what there is to tell is added to `told`."""
    effect, untested = hidden.effect, WORLDS[experiment].untested
    sets = [
        {cause.signature.effect, *(rival.effect for rival in cause.rivals)}
        for cause in (item.cause for item in found.found)
    ]
    right = bool(sets) and any(effect.name in each for each in sets)
    wrong = any(effect.name not in each for each in sets)
    largest = main_gain(found.gains, found.problem)
    gain = None if largest is None else largest.change
    if wrong or (right and (gain is None or gain.low <= 0.0)):
        outcome = "MISS"
    elif right:
        outcome = "ok"
    elif not _testable(found, effect, untested):
        outcome = "not testable"
    else:
        outcome = "faint" if shown.rho < FAINT and _silent(found) else "MISS"
    told.append(f"{found.verdict.value:<13} {_names(found) or '-'}")
    item = next((f for f in found.found if f.cause.signature.effect == effect.name), None)
    interval = None if item is None else _interval(item, hidden)
    covered = None
    if interval is not None:
        truth = _truth(experiment, hidden, seed)
        covered = interval.low <= truth <= interval.high
        told.append(
            f"size {'in' if covered else 'NOT in'} [{interval.low:.4g}, {interval.high:.4g}]"
            + ("" if truth == hidden.size else f" (as stated {truth:.4g})")
        )
    if right and gain is not None:
        first = found.found[0].cause.gain
        told.append(
            f"gain {gain.value:.0%} [{gain.low:.0%}, {gain.high:.0%}]"
            f" (when named {first.value:.0%} [{first.low:.0%}, {first.high:.0%}])"
        )
    if not right:
        told.append(_reason(found, effect, untested))
    return outcome, covered


def _switched(experiment: str, hidden: Hidden) -> tuple[str, ...]:
    """The channels that are exchanged, or the one that is turned."""
    (owner,) = hidden.owners
    if hidden.effect.scope is Scope.LEG:
        return (f"{owner}.{hidden.parameter.rsplit('_', 1)[1]}",)
    channels, pair = WORLDS[experiment].channels, ("swap_first", "swap_second")
    return tuple(channels[int(hidden.values[f"{owner}.{name}"])] for name in pair)


def _names(found: Investigation) -> str:
    """Named causes with their rivals and places."""
    said = []
    for item in found.found:
        cause = item.cause
        rivals = dict.fromkeys(r.effect for r in cause.rivals)
        where = f"{item.owner}{_shapes(item)}"
        said.append(" or ".join([f"{cause.signature.effect} ({where})", *rivals]))
    nearest = " ".join(f"(nearest {f.cause.signature.effect})" for f in found.nearest)
    return ", ".join(said) or nearest


def _shapes(item: Found) -> str:
    """Fitted values of all but the size that is told."""
    told = item.cause.signature.parameter
    pairs = zip(item.parameter_names, item.intervals, strict=True)
    named = {name.rsplit(".", 1)[1]: interval.value for name, interval in pairs}
    return "".join(f", {n} {v:.3g}" for n, v in named.items() if n != told and n in SHAPES)


def _silent(found: Investigation) -> bool:
    return found.verdict in (Verdict.NONE, Verdict.UNDERPOWERED)


def _testable(found: Investigation, effect: Effect, untested: Mapping[str, str]) -> bool:
    """Whether the report says of an effect anything but that these data cannot test it."""
    if effect.name in untested or any(e.effect == effect.name for e in found.problem.excluded):
        return False
    rows = [row for row in found.rounds[0].effects if row.signature.effect == effect.name]
    return any(row.status is not EffectStatus.NOT_TESTABLE for row in rows)


def _reason(found: Investigation, effect: Effect, untested: Mapping[str, str]) -> str:
    """What the report says of an effect that it did not name."""
    reasons = [row.reason for row in found.rounds[0].effects if row.signature.effect == effect.name]
    return f"({untested.get(effect.name) or '; '.join(reasons) or 'not in the table'})"


def _interval(item: Found, hidden: Hidden) -> Interval | None:
    """The 95 % interval of the hidden size; None where another place was named, or a switch."""
    effect = hidden.effect
    owner = dict(item.cause.signature.owners)
    carriers = {member for members in owner.values() for member in members}
    if effect.name in SWITCHES or carriers != {m for ms in hidden.owners.values() for m in ms}:
        return None
    if item.cause.signature.parameter == hidden.parameter:
        return item.cause.size
    for name, interval in zip(item.parameter_names, item.intervals, strict=True):
        if name == f"{item.owner}.{hidden.parameter}":
            return interval
    return None


def _truth(experiment: str, hidden: Hidden, seed: int) -> float:
    """The hidden size as reports state it: what it does at the recorded loads."""
    if hidden.effect.stated is None:
        return hidden.size
    case = clean(experiment, seed).case
    chain = Chain((Link(hidden.effect, dict(hidden.owners)),))
    widths = [0.0]
    for log in WORLDS[experiment].record(None, seed, False):
        truth, _ = case.chain.remove(log, case.values)
        widths += hidden.effect.stated(truth, chain.apply(truth, hidden.values)[0]).tolist()
    return max(widths)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("experiment", "effect"), [pytest.param(*c, id=f"{c[0]}-{c[1].name}") for c in CASES]
)
def test_twice_what_matters_is_named(experiment: str, effect: Effect, seed: int) -> None:
    """The right name or a rival set that holds it, no other one, and a gain on held-out data."""
    found = answer(experiment, effect, seed)
    if (experiment, effect.name) not in KNOWN_MISSES:
        assert found.outcome != "MISS", found.line


@pytest.mark.slow
def test_intervals_hold_the_sizes() -> None:
    """Over all cases together: one interval of twenty may miss; what is repaired is told."""
    if not ANSWERS:
        pytest.skip("no case was diagnosed before it")
    outcomes = [found.outcome for found in ANSWERS.values()]
    counts = ", ".join(f"{outcomes.count(o)} {o}" for o in dict.fromkeys(outcomes))
    covered = {case: a.covered for case, a in ANSWERS.items() if a.covered is not None}
    told = [f"{len(outcomes)} cases: {counts}",
            f"{sum(covered.values())} of {len(covered)} intervals hold the size"]  # fmt: skip
    told += [f"not held: {' '.join(case[:2])}" for case, holds in covered.items() if not holds]
    for known, reason in KNOWN_MISSES.items():
        mine = [found.outcome for case, found in ANSWERS.items() if case[:2] == known]
        if mine and "MISS" not in mine:
            told.append(f"repaired, take it off the list: {' '.join(known)} ({reason})")
    sys.stdout.write("\n" + "\n".join(told) + "\n")
    judged = [holds for case, holds in covered.items() if case[:2] not in ANOTHER_SHAPE]
    assert stats.binom.cdf(sum(judged), len(judged), 0.95) > LEAST_P

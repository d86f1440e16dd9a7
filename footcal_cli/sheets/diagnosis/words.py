"""Sizes, gains and causes as they stand in sentences."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.gain import Gain
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.evidence import Interval
from footcal_cli.report import number


def words(name: str) -> str:
    """An effect's name for a sentence."""
    return name.replace("_", " ")


def with_interval(interval: Interval, unit: str) -> str:
    """``1.1 N [0.9, 1.3]``."""
    spread = interval.high - interval.low
    digits = 3
    if np.isfinite(spread) and spread > 0 and interval.value:
        digits = int(np.clip(np.ceil(np.log10(abs(interval.value) / spread)) + 2, 2, 6))
    unit = f" {unit}" if unit and unit != "-" else ""
    return (
        f"{number(interval.value, digits)}{unit} "
        f"[{number(interval.low, digits)}, {number(interval.high, digits)}]"
    )


def size_words(item: Found) -> str:
    """Every fitted number of an effect with its interval and unit."""
    signature = item.cause.signature
    parts = []
    for name, interval in zip(item.parameter_names, item.intervals, strict=True):
        parameter = name.rsplit(".", 1)[1]
        unit = signature.unit if parameter == signature.parameter else ""
        parts.append(f"{words(parameter)} {with_interval(interval, unit)}")
    return ", ".join(parts)


def main_gain(found: Investigation) -> Gain | None:
    """The output that gained most."""
    return max(found.gains, key=lambda g: g.change.value, default=None)


def gain_words(found: Investigation) -> str:
    """``Held-out error of fz falls 19 % [14, 24], 0.41 to 0.33 N.``."""
    gain = main_gain(found)
    if gain is None:
        return ""
    low, value, high = (100 * x for x in (gain.change.low, gain.change.value, gain.change.high))
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    return (
        f"Held-out error of {gain.output} falls {value:.0f} % [{low:.0f}, {high:.0f}], "
        f"{number(gain.before, 3)} to {number(gain.after, 3)} {gain.unit}, better in {better} of "
        f"{len(gain.per_block)} blocks"
    )


def causes_words(found: Investigation) -> str:
    """All named effects with place and sizes."""
    return "; ".join(
        f"{words(f.cause.signature.effect)} in {f.cause.signature.where}, {size_words(f)}"
        for f in found.found
    )


def rival_groups(found: Investigation) -> tuple[tuple[str, ...], ...]:
    """Effects that do as well as each named one, itself first."""
    groups = []
    for item in found.found:
        cause = item.cause
        if cause.rivals:
            names = dict.fromkeys([cause.signature.effect, *(r.effect for r in cause.rivals)])
            groups.append(tuple(names))
    return tuple(groups)


def could_not(found: Investigation) -> str:
    """Every effect that these data cannot test, with its reason."""
    rows = [
        f"{words(r.signature.effect)} ({r.reason})"
        for r in found.rounds[0].effects
        if r.status is EffectStatus.NOT_TESTABLE
    ]
    rows += [f"{words(e.effect)} ({e.reason})" for e in found.problem.excluded]
    return "; ".join(rows)

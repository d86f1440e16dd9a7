"""Sizes, gains and causes as they stand in sentences."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.gain import Gain
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.evidence import Interval
from footcal_cli.report import number

OUTPUTS = {
    "fz": "vertical force",
    "fx": "force along x",
    "fy": "force along y",
    "mx": "moment about x",
    "my": "moment about y",
    "mz": "moment about z",
    "tx": "torque about x",
    "ty": "torque about y",
    "tz": "torque about z",
    "moment_x": "moment along x",
    "moment_y": "moment along y",
    "force": "force",
    "swing": "force of unloaded cells",
}
"""Outputs of the balances, for people."""


def words(name: str) -> str:
    """An effect's name for a sentence."""
    return name.replace("_", " ")


def output_words(name: str) -> str:
    """An output's name for a sentence."""
    owner, _, plain = name.rpartition(".")
    said = OUTPUTS.get(plain, words(plain))
    return f"{said} ({words(owner)})" if owner else said


def place_words(where: str) -> str:
    """`` in cell left rr``, `` in all cells``; nothing for the robot as a whole."""
    if where in ("", "robot"):
        return ""
    return f" in {words(where)}"


def together(names: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    items = list(dict.fromkeys(names))
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}"


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
        said = words(parameter.removeprefix(f"{signature.effect}_"))
        said = "" if parameter == signature.effect else f"{said} "
        parts.append(f"{said}{with_interval(interval, unit)}")
    return ", ".join(parts)


def main_gain(found: Investigation) -> Gain | None:
    """The output that gained most."""
    return max(found.gains, key=lambda g: g.change.value, default=None)


def gain_words(found: Investigation) -> str:
    """What the error falls by on data that no fit has seen."""
    gain = main_gain(found)
    if gain is None:
        return ""
    low, value, high = (100 * x for x in (gain.change.low, gain.change.value, gain.change.high))
    better = int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))
    return (
        f"With it in the model the {output_words(gain.output)} is wrong by "
        f"{number(gain.after, 3)} instead of {number(gain.before, 3)} {gain.unit} on data the fit "
        f"had not seen (−{value:.0f} % [{low:.0f}, {high:.0f}]; better in {better} of "
        f"{len(gain.per_block)} blocks)"
    ).replace("−-", "+")


def rival_groups(found: Investigation) -> tuple[tuple[str, ...], ...]:
    """Effects that do as well as each named one, itself first."""
    groups = []
    for item in found.found:
        cause = item.cause
        if cause.rivals:
            names = dict.fromkeys([cause.signature.effect, *(r.effect for r in cause.rivals)])
            groups.append(tuple(names))
    return tuple(groups)


def cause_words(item: Found) -> str:
    """One effect with place and sizes."""
    signature = item.cause.signature
    return f"{words(signature.effect)}{place_words(signature.where)}, {size_words(item)}"


def causes_words(found: Investigation) -> str:
    """All named effects with place and sizes."""
    return "; ".join(cause_words(item) for item in found.found)


def could_not(found: Investigation, untested: Mapping[str, str]) -> str:
    """Every effect that these data cannot test, those with one reason together."""
    reasons: dict[str, list[str]] = {}
    for row in found.rounds[0].effects:
        if row.status is EffectStatus.NOT_TESTABLE:
            reasons.setdefault(_plain(row.reason), []).append(words(row.signature.effect))
    for item in found.problem.excluded:
        reasons.setdefault(item.reason, []).append(words(item.effect))
    for name, reason in untested.items():
        reasons.setdefault(reason, []).append(words(name))
    return "; ".join(f"{', '.join(names)} ({reason})" for reason, names in reasons.items())


def _plain(reason: str) -> str:
    """A reason without its number, so that like ones stand together."""
    if "visible beside the calibration" in reason:
        return "the calibration absorbs nearly all of it"
    if "informative blocks" in reason:
        return "too few blocks know of it"
    return reason

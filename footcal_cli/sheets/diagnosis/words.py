"""Sizes, gains and causes as they stand in sentences."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.gain import Gain, main_gain
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.effects.contract import is_six_axis
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.written import Written
from footcal_cli.plots.words import output_words, words
from footcal_cli.records.display_units import display_unit
from footcal_cli.report import number, plural, power_of_ten


def place_words(where: str) -> str:
    """`` in left_rr``, `` in all cells``; nothing for the robot as a whole."""
    return "" if where in ("", "robot") else f" in {where}"


def where_of(signature: Signature) -> str:
    """Where an effect sits: a six-axis transducer has axes where others have cells."""
    if not is_six_axis([member for _, members in signature.owners for member in members]):
        return signature.where
    return _CELLS.sub(lambda found: f"ax{'es' if found[1] else 'is'}", signature.where)


def together(names: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    items = list(dict.fromkeys(names))
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}"


_CELLS = re.compile(r"\bcell(s?)\b")
_PLAIN_FROM = 0.5
_POWER_BELOW = 1e-3
"""Smaller numbers share a power of ten with the ends of their interval."""


def handy_unit(value: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which a size has few digits."""
    factor, handy = (100.0, "%") if unit == "-" else display_unit(unit, [value])
    return (1.0, unit) if unit in ("m", "s") and abs(value) >= _PLAIN_FROM else (factor, handy)


def scaled(interval: Interval, factor: float) -> Interval:
    """The same interval in another unit."""
    return replace(
        interval, value=factor * interval.value, low=factor * interval.low,
        high=factor * interval.high,
    )  # fmt: skip


def with_interval(interval: Interval, unit: str) -> str:
    """``1.1 N [0.9, 1.3]``."""
    spread = interval.high - interval.low
    digits = 3
    if np.isfinite(spread) and spread > 0 and interval.value:
        digits = int(np.clip(np.ceil(np.log10(abs(interval.value) / spread)) + 2, 2, 6))
    unit = f" {unit}" if unit and unit != "-" else ""
    value, *ends = (interval.value, interval.low, interval.high)
    largest = max((abs(x) for x in (value, *ends) if np.isfinite(x)), default=0.0)
    if 0 < largest < _POWER_BELOW:
        power = int(np.floor(np.log10(largest)))
        shared = with_interval(scaled(interval, 10.0**-power), "")
        return f"({shared}) × {power_of_ten(power)}{unit}"
    size = abs(float(f"{value:.{digits - 1}e}")) if np.isfinite(value) else 0.0
    decimals = max(digits - 1 - int(np.floor(np.log10(size or largest or 1.0))), 0)
    shown = [
        f"{x:z,.{decimals}f}".replace("-", "−") if np.isfinite(x) else "–" for x in (value, *ends)
    ]
    return f"{shown[0]}{unit} [{shown[1]}, {shown[2]}]"


def handy(interval: Interval, unit: str) -> str:
    """With the interval, in the unit of the evidence table."""
    factor, unit = handy_unit(interval.value, unit)
    return with_interval(scaled(interval, factor), unit)


def size_words(item: Found) -> str:
    """The sizes of an effect with interval and unit; of many owners the surest one's."""
    signature = item.cause.signature
    whose = f"surest in {item.owner}: " if len(signature.owners) > 1 else ""
    if stated_as := item.effect.stated_as:
        return f"{whose}{stated_as} {handy(item.cause.size, signature.unit)}"
    shapes = {name for name, _ in signature.shape}
    units = item.units
    said: list[str] = []
    for name, interval in zip(item.parameter_names, item.intervals, strict=True):
        owner, parameter = name.rsplit(".", 1)
        seen = interval.low * interval.high > 0 or parameter == signature.parameter
        if owner == item.owner and parameter not in shapes and seen:
            called = _size_name(parameter, signature.effect)
            # the size of an effect holds in every form that the data leave open
            own = item.cause.size if parameter == signature.parameter else interval
            said.append(f"{called}{handy(own, units[parameter])}")
    return f"{whose}{', '.join(said)}" if said else ""


def _size_name(parameter: str, effect: str) -> str:
    """A parameter's name without its effect's, nothing where they are the same."""
    return "" if parameter == effect else f"{words(parameter.removeprefix(f'{effect}_'))} "


def shape_words(item: Found) -> str:
    """What shapes an effect, as it was fitted; with the size where another one is stated."""
    effect = item.effect
    shapes = {name for name, _ in item.cause.signature.shape}
    shapes |= {effect.size.name} if effect.stated_as else set()
    units = item.units
    parts = [
        f"{_size_name(name.rsplit('.', 1)[1], effect.name)}"
        f"{handy(interval, units.get(name.rsplit('.', 1)[1], ''))}"
        for name, interval in zip(item.parameter_names, item.intervals, strict=True)
        if name.rsplit(".", 1)[1] in shapes
    ]
    parts += [
        f"{_size_name(name, effect.name)}{number(value)} {units[name]}"
        for name, value in item.placed.items()
    ]
    return ", ".join(parts[:2])


def share_text(share: float, *, sign: bool = False) -> str:
    """A share of the error that goes, ``10.1 %``; ``worse`` where the error more than doubles.

    On a block that a model cannot predict the share has any size, −2·10⁹ % too. The number itself
    stands in the JSON.
    """
    if share < -1.0:
        return "worse"
    return f"{100 * share:{'+' if sign else ''}z.1f} %".replace("-", "−")


def share_interval(low: float, high: float, decimals: int = 1) -> str:
    """The bounds of such a share in per cent: ``[3.0, 4.7]``, ``[< −100, 4.7]``."""
    texts = (f"{100 * max(x, -1.0):z.{decimals}f}".replace("-", "−") for x in (low, high))
    low_text, high_text = (
        f"< {text}" if x < -1.0 else text for x, text in zip((low, high), texts, strict=True)
    )
    return f"[{low_text}, {high_text}]"


def gain_words(found: Investigation) -> str:
    """What the error falls by on data that no fit has seen."""
    gain = main_gain(found.gains, found.problem)
    if gain is None:
        return ""
    if found.once:
        how = (
            "happened once" if all(f.placed for f in found.found) else "goes on along the whole log"
        )
        return f"It {how}, so that no other part of the log can confirm it"
    value = gain.change.value
    better, blocks = gain.better_blocks, len(gain.per_block)
    of = f"{blocks} blocks"
    if blocks < found.problem.blocks:
        of = f"the {blocks} blocks that hold it"
    falls = "falls" if value >= 0 else "grows"
    size = "more than twofold" if value < -1.0 else f"{100 * abs(value):.0f} %"
    return (
        f"On data the fit had not seen, the error of the {output_words(gain.output)} {falls} from "
        f"{number(gain.before, 3)} to {number(gain.after, 3)} {gain.unit} "
        f"({size} {share_interval(gain.change.low, gain.change.high, 0)}, "
        f"better in {better} of {of})"
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


def subject_words(signature: Signature, written: Written) -> str:
    """An effect with its place: a cell, or the hole or weight by the log's own name."""
    which = written.named(signature)
    where = f" ({which})" if which else place_words(where_of(signature))
    return f"{words(signature.effect)}{where}"


def cause_words(item: Found, written: Written) -> str:
    """One effect with place and sizes."""
    return f"{subject_words(item.cause.signature, written)}, {size_words(item)}"


def causes_words(found: Investigation) -> str:
    """All named effects with place and sizes."""
    return "; ".join(cause_words(item, found.case.written) for item in found.found)


def not_testable(found: Investigation, untested: Mapping[str, str]) -> dict[str, list[str]]:
    """Reason -> effects that these data cannot test for it."""
    reasons: dict[str, list[str]] = {}
    for row in found.rounds[0].effects:
        if row.status is EffectStatus.NOT_TESTABLE:
            reasons.setdefault(_plain(row.reason), []).append(words(row.signature.effect))
    for item in found.problem.excluded:
        reasons.setdefault(_plain(item.reason), []).append(words(item.effect))
    for name, reason in untested.items():
        reasons.setdefault(_plain(reason), []).append(words(name))
    return reasons


def cannot_lines(found: Investigation, untested: Mapping[str, str]) -> list[str]:
    """How many effects could not be tested; the table says which and why."""
    count = sum(map(len, not_testable(found, untested).values()))
    where = "table 'What could not be tested' in the report"
    return [f"{plural(count, 'effect')} could not be tested here ({where})."] if count else []


def _plain(reason: str) -> str:
    """A reason without its number and remedy, so that like ones stand together."""
    if "calibration absorbs" in reason:
        return "the calibration absorbs nearly all of it"
    if "informative blocks" in reason:
        return "too few blocks are informative about it"
    return reason.split(";")[0]


def matters(found: Investigation, item: Found) -> bool:
    """Whether a cause is as large as what matters: another question than whether it is there.

    By its own size, or, if it is alone, by an error that it surely makes smaller: one component of
    several may be small.

    Of a set, whether any of it is: the loop that stands for a gain that changed may be narrow. What
    happened once is as large as it is, whatever a calibration that is tracked takes up of it.
    """
    signature, once = item.cause.signature, found.once
    if len(found.found) == 1 and any(_is_worth_it(found, gain) for gain in found.gains):
        return True
    rows = {r.signature.effect: r for r in reversed(item.answer.effects)}
    if signature.effect not in rows:
        return True
    sizes = {s.effect: rows[s.effect].size for s in item.cause.rivals if s.effect in rows}
    sizes[signature.effect] = item.cause.size
    seen = {effect: rows[effect].visible if once else 1.0 for effect in sizes}
    return any(abs(s.value) >= seen[e] * rows[e].smallest for e, s in sizes.items())


def something_matters(found: Investigation) -> bool:
    """Whether any named cause is as large as what matters."""
    return any(matters(found, item) for item in found.found)


def _is_worth_it(found: Investigation, gain: Gain) -> bool:
    """Whether what an error surely loses is as large as what matters."""
    smallest = found.case.tolerance_nm if gain.unit == "Nm" else found.case.tolerance_n
    bought = max(gain.before**2 - gain.after**2, 0.0)
    return bool(gain.change.low > 0.0 and bought >= smallest**2)


def alike_by_law(rival: str, where: str, mine: str) -> str:
    """That a rival that no columns stand for acts as a named cause does, without a full stop."""
    said = f"{words(rival)}{place_words(where)} acts as {words(mine)} does"
    return said[0].upper() + said[1:]


def remedy_of(found: Investigation, item: Found) -> str:
    """What a user would do about a cause."""
    if found.model is None:
        return ""
    links = found.model.chain.links
    name = item.cause.signature.effect
    return next((link.effect.remedy for link in links if link.effect.name == name), "")

"""What the calibration in use holds already: effects that a diagnosis therefore cannot find.

Part of the room `sheets`, beside `footcal_cli.sheets.diagnosis.answer`.
"""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.core.chain import Link
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.inference.case import Case, channels_of
from footcal_cli.core.quality import some_of
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import HeldRecord
from footcal_cli.report import number
from footcal_cli.sheets.diagnosis.words import handy_unit, together

_MOST_NAMED = 3


def held_by(case: Case) -> tuple[HeldRecord, ...]:
    """Effects of the chain that a diagnosis starts from; how legs hang is fitted to every log."""
    return tuple(
        HeldRecord(effect=link.effect.name, owners=tuple(link.owners)) for link in _held(case)
    )


def held_words(case: Case) -> str:
    """The same in a sentence, with the largest size of each; empty where it holds none."""
    every = channels_of(case.logs)
    held = [f"{words(k.effect.name)}{_of(list(k.owners), every)}{_most(k, case)}"
            for k in _held(case)]  # fmt: skip
    return f"The calibration in use already holds: {'; '.join(held)}." if held else ""


def _held(case: Case) -> list[Link]:
    return [
        link
        for link in case.chain.links
        if link.effect.name not in case.experiment.calibration
        and Trait.HUNG not in link.effect.traits
    ]


def _most(link: Link, case: Case) -> str:
    """`` (most: 5.8 mm in left_2)``: the size that is largest in usual sizes, of several owners."""
    sizes = [
        (abs(case.values.get(f"{owner}.{p.name}", p.neutral) - p.neutral) / p.prior_sd, owner, p)
        for owner in link.owners
        for p in link.effect.sizes
    ]
    times, owner, size = max(sizes, key=lambda s: s[0], default=(0.0, "", None))
    if len(link.owners) < 2 or not times or size is None:
        return ""
    value = case.values[f"{owner}.{size.name}"]
    factor, unit = handy_unit(value, size.unit)
    return f" (most: {number(factor * value, 2)} {unit} in {owner})"


def _of(owners: Sequence[str], channels: Sequence[str]) -> str:
    """`` of left``: the foot where it is of all its cells, else the first of the owners."""
    if list(owners) in (["robot"], [""]):
        return ""
    groups: dict[str, set[str]] = {}
    for name in channels:
        groups.setdefault(name.rpartition("_")[0], set()).add(name)
    left, said = dict.fromkeys(owners), list[str]()
    for foot, own in groups.items():
        if foot and len(own) > 1 and own <= left.keys():
            said.append(foot)
            left = {name: None for name in left if name not in own}
    said += left
    many = len(said) > _MOST_NAMED
    return f" of {some_of(said, _MOST_NAMED) if many else together(said)}"

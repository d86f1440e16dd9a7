"""Loads that stand still in a recording without a load column: how many, at which readings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from footcal_cli.core.bench.plateaus import PlateauOptions, Plateaus, find_plateaus
from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.plan import Blank
from footcal_cli.sniff.said_weights import said_weight
from footcal_cli.sniff.texts import FEW
from footcal_cli.sniff.tokens import with_unit
from footcal_cli.sniff.units import LOADS, MASSES, known_unit

_FEWEST, _ROWS_A_HOLD = 3, 8
_SHORT_S = 4.0
"""Holds shorter than this need other options: by default 3 s of them must stand still."""
_SHORTER_S = (2.0, 1.0, 0.5)
_MOST_LISTED = 12
_FINER = (0.01, 0.005, 0.002)
"""Shares of the span below which loads are the same, where a recipe has to say so."""
_NUMBER = r"\d+(?:\.\d+)?"
_LISTED = re.compile(
    r"(?:loads?|weights?|masses|gewichte|lasten|charges|cargas|pesi)\b[^:=\d]*[:=]\s*"
    rf"(?P<loads>{_NUMBER}(?:[,;]\s*{_NUMBER})+)\s*(?P<unit>[A-Za-z]+)\s*$",
    re.IGNORECASE,
)
"""Loads in a remark: ``loads in order: 0, 1, 2 kg``."""
_NOTHING_ON = frozenset(
    ["empty", "unloaded", "zero", "none", "nothing", "leer", "vide", "vuoto", "vacío", "0"]
)
"""What is typed when no weight lies on a cell."""


def short_holds(time_s: FloatArray, load: FloatArray) -> tuple[str, ...]:
    """Options for a recording whose known load stays for less than 4 s at a time; empty otherwise.

    Half of the shortest hold must stand still, looked at in windows of a third of it. Where
    most of the time passed in longer holds, these are enough; a load of many values is a reference
    in motion.

    Parameters
    ----------
    time_s, load
        Shape (n,).
    """
    good = np.isfinite(time_s) & np.isfinite(load)
    at, put = time_s[good], load[good]
    starts = np.flatnonzero(np.r_[True, np.diff(put) != 0])
    levels = np.unique(put).size
    if starts.size < _FEWEST or levels > FEW or put.size < _ROWS_A_HOLD * starts.size:
        return ()
    stayed = np.diff(np.r_[at[starts], at[-1]])
    rows = np.diff(np.r_[starts, put.size])
    short = stayed < _SHORT_S
    if stayed[short].sum() <= stayed[~short].sum():
        return ()
    shortest = float(stayed[rows >= _ROWS_A_HOLD].min(initial=_SHORT_S))
    if not 0 < shortest < _SHORT_S:
        return ()
    said = f"window_s = {shortest / 3:.3g}, min_hold_s = {shortest / 2:.3g}"
    return (f"plateaus = {{ {said} }}    # likely: each load stayed for {shortest:.3g} s or more",)


def typed_loads(
    time_s: FloatArray, reading: FloatArray, typed: Sequence[tuple[float, str]]
) -> tuple[str, ...]:
    """Options that give each hold the load that was typed when it was put on.

    Parameters
    ----------
    time_s, reading
        Shape (n,).
    typed
        Moments (s) and what was typed then: ``100 g``, ``2 kg``, ``empty``.

    Returns
    -------
    lines
        Of ``[offline_fit]``; none where a hold has no weight, or two that differ.
    """
    for same_level in (PlateauOptions().same_level, *_FINER):
        loads = _per_hold(_holds(time_s, reading, same_level=same_level), typed)
        if len(set(loads)) > 1 and None not in loads:
            said = ", ".join(f"{load:.6g}" for load in loads)
            line = f'plateaus.loads = "{said} kg"    # likely: as typed, in order of time'
            finer = f"plateaus.same_level = {same_level:g}    # of the span: loads are close"
            return (line, finer) if same_level in _FINER else (line,)
    return ()


def said_loads(time_s: FloatArray, reading: FloatArray, above: Sequence[str]) -> tuple[str, ...]:
    """Options that give each hold its load as a line above the table lists them.

    Parameters
    ----------
    time_s, reading
        Shape (n,).
    above
        Lines above the table, of which one may say ``loads: 0, 1, 2 kg``.

    Returns
    -------
    lines
        Of ``[offline_fit]``; none unless one line lists as many loads as there are holds.
    """
    lists = [found for line in above if (found := _LISTED.search(line))]
    if len(lists) != 1 or known_unit(lists[0]["unit"]) not in LOADS:
        return ()
    loads = re.findall(_NUMBER, lists[0]["loads"])
    if len({*loads}) < 2:
        return ()
    said = f"{', '.join(loads)} {known_unit(lists[0]['unit'])}"
    line = f'plateaus.loads = "{said}"    # likely: as listed above the table, in order of time'
    for shortest in (PlateauOptions().min_hold_s, *_SHORTER_S):
        window = min(PlateauOptions().window_s, shortest * 2 / 3)
        holds = _holds(time_s, reading, min_hold_s=shortest, window_s=window)
        if holds.level.size == len(loads):
            short = f"plateaus.min_hold_s = {shortest:g}    # as many holds as listed loads"
            own = (short, f"plateaus.window_s = {window:.3g}") if shortest in _SHORTER_S else ()
            return (line, *own)
    return ()


def _per_hold(found: Plateaus, typed: Sequence[tuple[float, str]]) -> list[float | None]:
    """The mass in kg that was typed for each load, None where it is none or not one."""
    loads: list[float | None] = []
    before = -np.inf
    for level in np.unique(found.level):
        until = float(found.stop_s[found.level == level].max())
        weights = {_kg(text) for at, text in typed if before < at <= until}
        loads.append(weights.pop() if len(weights) == 1 else None)
        before = until
    return loads


def _kg(text: str) -> float | None:
    """A mass that was typed; None for any other text."""
    if text.strip().lower() in _NOTHING_ON:
        return 0.0
    said = said_weight(text)
    if said is not None and all(unit in MASSES for _, unit in said):
        return sum(number * MASSES[unit] for number, unit in said)
    found = with_unit(text)
    size = MASSES.get(known_unit(found[1]) or "") if found else None
    return None if found is None or size is None else float(found[0].replace(",", ".")) * size


def _holds(time_s: FloatArray, reading: FloatArray, **own: Any) -> Plateaus:
    """Holds of a recording without stamps or readings that are none."""
    good = np.isfinite(reading) & np.isfinite(time_s)
    order = np.argsort(time_s[good], kind="stable")
    options = replace(PlateauOptions(), **own)
    return find_plateaus(time_s[good][order], reading[good][order], options)


def blank_loads(time_s: FloatArray, reading: FloatArray, *, stamped: bool = True) -> Blank:
    """The loads to be filled in, with what was found of their holds.

    Parameters
    ----------
    time_s, reading
        Shape (n,).
    stamped
        Whether the log has stamps; without any the holds may be of any length.
    """
    found, own = _holds(time_s, reading), tuple[str, ...]()
    for shortest in _SHORTER_S:
        if np.unique(found.level).size > 1:
            break
        window = min(PlateauOptions().window_s, shortest * 2 / 3)
        found = _holds(time_s, reading, min_hold_s=shortest, window_s=window)
        own = (f"min_hold_s = {shortest:g}", f"window_s = {window:.3g}")
    levels = np.unique(found.level).size
    own = own if levels > 1 else ()
    medians = [
        f"{np.median(found.median[found.level == level]):.0f}"
        for level in np.unique(found.level)[:_MOST_LISTED]
    ] + ["…"] * (levels > _MOST_LISTED)
    if not levels and not stamped:
        said = "no hold was found, and there are no stamps; better: a column load_kg"
    elif not levels:
        said = "no hold was found; widen min_hold_s and max_scatter"
    else:
        said = f"{levels} holds were found, at readings of {', '.join(medians)}"
    places = ", ".join(" " for _ in range(max(levels, 2)))
    # what holds of these lines as it is stands there without a mark of a comment
    own = (f"{own[0]}    # likely: holds are short", *own[1:]) if own else ()
    return Blank(
        ("# [offline_fit.plateaus]"[2 * bool(own) :], *own,
         f'# loads = "{places} kg"    # in order of time: {said}'),
        "the log does not say which loads were put on",
    )  # fmt: skip

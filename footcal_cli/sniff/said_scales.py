"""What lines above a table say of the cells' sensitivity: ``1120 counts per newton``, in any words.

Room: sniff; asked by said_above.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.sniff.cells import NAMEPLATE, WEIGHTS
from footcal_cli.sniff.guesses import numbers_of
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.units import GRAVITY_MPS2, LOADS, VOLTAGES
from footcal_cli.tables.units import conversion

_NUMBER = r"(?<![\d.,])\d{1,3}(?: \d{3})+|(?<![\d.,])\d+(?:[.,]\d+)?(?:[eE]-?\d+)?"
_COUNTS = (
    r"(?i:counts?|cts?|codes?|lsbs?|digits?|bits?|ticks?|steps?|units?|zliczeń|zliczenia|impuls\w*|"
    r"cuentas?|conteos?|contagens|contagem|conteggi\w*|punti|tellinger|enheter|inkrement\w*|zähl\w*|"
    r"tell\w*|dílků|dilku|jednotek|coups|points?|pas|pulsos|sayım|sayim|lukemaa?|hodnot|szám\w*|"
    r"μετρήσεις|đơn vị|カウント)"
)
_VOLTS = r"mV/V|mV|uV|V|[Vv]olts?"
_FORCES = r"kN|mN|N|kgf?|g|lbf?|[Nn]ew?tons?|[Nn]iuton\w*|[Nn]jutn\w*|[Νν]ιούτον"
_READ = rf"(?:{_COUNTS}|{_VOLTS})"
_LINK = (
    r"\s*(?:[/=≙@]|\b(?:per|pro|je|par|por|pr|på|paa|na|za|a|à|at|bei|for|för|for|für|vid|bij|ved|"
    r"a cada|για)\b\.?)\s*"
)
_ONE_WAY = re.compile(
    rf"(?P<read>{_NUMBER})?\s*(?<![^\W\d])(?P<in>{_READ})(?![^\W\d]){_LINK}"
    rf"(?P<force>{_NUMBER})?\s*(?P<unit>{_FORCES})(?![\w/])"
)
_OTHER_WAY = re.compile(
    rf"(?P<force>{_NUMBER})?\s*(?<![^\W\d])(?P<unit>{_FORCES}){_LINK}"
    rf"(?P<read>{_NUMBER})?\s*(?P<in>{_READ})(?![\w/])"
)
"""A reading for a force, or a force for a reading; one of the two numbers may be missing."""
_OFF_BY = re.compile(
    r"[^\d.;]{0,25}?(?:±|\+[-/]+|\+\s*[-–]|(?i:within|about))\s*(\d+(?:[.,]\d+)?)\s*%"
)


def scale_in(
    above: Sequence[str], unit: str | None = None
) -> tuple[float, float | None, str] | None:
    """Newtons per unit read, how far that may be off as a share, and the words; None without one.

    Parameters
    ----------
    unit
        In which the cells are read: V, mV/V …; None for counts, or where nothing says it.

    >>> scale_in(["The cells give 1120 counts per newton, +-3 %."])[:2]
    (0.0008928571428571428, 0.03)
    >>> scale_in(["Amplifier: 600 N = 4,0 V."], "V")[0]
    150.0
    """
    found: dict[float, tuple[float | None, str]] = {}
    text = "\n".join(above)  # a sentence may go on in the next line
    for said in (*_ONE_WAY.finditer(text), *_OTHER_WAY.finditer(text)):
        read, force = (_number(said[name]) for name in ("read", "force"))
        kind, per_unit = _kind(said["in"])
        fits = kind in ((unit,) if unit else ("count", "V"))
        if not fits or (read is None and force is None) or 0.0 in (read, force):
            continue
        newton = said["unit"] if said["unit"] in (*LOADS, "kgf", "lbf") else "N"
        one = conversion(newton, "N", GRAVITY_MPS2).slope
        off = _OFF_BY.match(text, said.end())
        sd = float(off[1].replace(",", ".")) / 100 if off else None
        words = " ".join(text[said.start() : (off or said).end()].split())
        found.setdefault((force or 1.0) * one / ((read or 1.0) * per_unit), (sd, words))
    if len(found) != 1:
        return None
    scale, (sd, words) = found.popitem()
    return scale, sd, words


def _kind(word: str) -> tuple[str, float]:
    """``count``, ``V`` or ``mV/V``, and how many of it one of the word's unit is."""
    if not re.fullmatch(_VOLTS, word):
        return "count", 1.0
    return ("mV/V", 1.0) if word == "mV/V" else ("V", VOLTAGES.get(word, 1e3) / 1e3)


def _number(text: str | None) -> float | None:
    return None if text is None else float(re.sub(r"\s", "", text).replace(",", "."))


def with_scale(plan: LogPlan) -> LogPlan:
    """The plan with the sensitivity of its cells that a line says, where it was asked for."""
    asked = [blank for blank in plan.blanks if blank in (WEIGHTS, NAMEPLATE)]
    entries = list(plan.read.values())
    units = {e.unit for e in entries if e.column is not None}
    said = scale_in(plan.file.text.above, units.pop()) if asked and len(units) == 1 else None
    if said is None:
        return plan
    scale, sd, line = said
    lines = (
        f"[robot.nameplate]\nscale_n_per_count = {_sign(plan) * scale:.6g}    # likely: '{line}'"
    )
    if sd is not None:
        lines += f"\nscale_relative_sd = {sd:g}    # likely: the same line"
    blanks = tuple(blank for blank in plan.blanks if blank not in asked)
    return replace(plan, robot=(*plan.robot, lines), blanks=blanks)


def _sign(plan: LogPlan) -> int:
    """Whether readings grow or fall with the load."""
    load = plan.entries.get("load_n")
    if load is None or load.column is None or load.column.values is None:
        return 1
    put = numbers_of(load.column)
    read = [numbers_of(e.column) for e in plan.read.values() if e.column is not None]
    total = np.sum([r for r in read if r.size == put.size], axis=0)
    good = np.isfinite(put) & np.isfinite(total)
    if not good.any() or np.ptp(put[good]) == 0:
        taken = all(e.column is not None and e.column.minus for e in plan.read.values())
        return -1 if taken and np.nanmean(total) < 0 else 1
    return 1 if np.polyfit(put[good], total[good], 1)[0] > 0 else -1

"""The evidence table: one row per effect that was tested, and what could not be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectRow, EffectStatus, Verdict
from footcal_cli.core.diagnosis.evidence_table import (
    AS_GOOD,
    found_row,
    order_of_row,
    possible,
    rival_row,
)
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.inference.written import Written
from footcal_cli.plots.words import words
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.words import (
    handy_unit,
    scaled,
    share_text,
    where_of,
    with_interval,
)

_MOST_ROWS = 20
_HOW_TO_READ = (
    "Present: beyond the size that matters. Absent: the whole interval lies within sizes that do "
    "not matter. Undecided: the interval straddles it, the effect fails a test, or such a size is "
    "not possible and another effect resembles it. Matters from: the size whose visible part "
    "changes an output by the tolerance. Found from: the size these data would have shown 4 times "
    "in 5. Gain: share of the RMS error of all outputs together, each in units of its noise, that "
    "goes on blocks the effect was not fitted to (worse: it more than doubles), and in how many "
    "blocks; the sentence at the top is about the output where it shows most. By chance: "
    "probability that random signs of whole blocks make any effect of the table look this strong. "
    "Visible: share that the calibration cannot absorb."
)


_WITHOUT_NAME = {
    Verdict.UNKNOWN: "the residual is still too large",
    Verdict.NONE: "it fails its refit, or what it explains does not matter",
}


def evidence_sheet(found: Investigation) -> Sheet:
    """One row per effect that was tested, by gain."""
    rows = [
        _evidence_row(row, found.problem.blocks, found.case.written)
        for row in table_rows(found)
        if row.status is not EffectStatus.NOT_TESTABLE
    ]
    nothing = found.verdict is Verdict.NONE
    return Sheet(
        "Evidence: every effect tested",
        ("effect", "where", "verdict", "size [95 %]", "matters from", "found from", "gain",
         "blocks better", "by chance", "visible"),
        rows,
        note=_HOW_TO_READ,
        brief=("effect", "where", "size [95 %]", "found from" if nothing else "gain", "verdict"),
        folded_after=_MOST_ROWS if len(rows) > _MOST_ROWS else 0,
    )  # fmt: skip


def _not_looked_for(found: Investigation, untested: Mapping[str, str]) -> list[tuple[str, str]]:
    """Effects without a row of their own, each once, with the reason."""
    reasons = {e.effect: e.reason for e in found.problem.excluded} | dict(untested)
    return list(reasons.items())


def table_rows(found: Investigation) -> list[EffectRow]:
    """Rows of named effects as they were accepted, the others beside the extended model."""
    if found.verdict is Verdict.BAD_DATA:
        return [_open(row, "the readings are wrong") for row in found.rounds[0].effects]
    if found.verdict in _WITHOUT_NAME:
        # what was accepted on the way did not stand in the end
        shown = found.rounds[-1 if found.verdict is Verdict.NONE else 0].effects
        return [
            _open(row, _WITHOUT_NAME[found.verdict]) if row.status is EffectStatus.PRESENT else row
            for row in shown
        ]
    rows: list[EffectRow] = []
    seen: set[str] = set()
    for item in found.found:
        cause = item.cause
        row = _row_of(item.answer.effects, cause.signature.effect)
        if row is None:
            continue
        mine = cause.signature.effect
        seen.add(mine)
        rivals = [r for r in {r.effect: r for r in cause.rivals}.values() if r.effect not in seen]
        weighed = [rival_row(item.answer, rival, mine) for rival in rivals]
        if item.answer.causes and item.answer.causes[0].signature.effect != mine:
            # weighed where the set was found, as its rivals are, not beside its first effect
            row = rival_row(item.answer, cause.signature, mine) or row
        row = found_row(row, [rival.effect for rival in rivals])
        row = replace(row, signature=cause.signature, size=cause.size)
        # blocks say nothing of what happened once
        rows.append(replace(row, p=cause.p, detectable=np.inf) if found.once else row)
        rows += [other for other in weighed if other is not None]
        seen |= {rival.effect for rival in rivals}
    rows += [r for r in found.rounds[-1].effects if r.signature.effect not in seen]
    return sorted(rows, key=order_of_row)


def _open(row: EffectRow, reason: str) -> EffectRow:
    """The row with nothing said of the effect, if it could be tested."""
    if row.status is EffectStatus.NOT_TESTABLE:
        return row
    return replace(row, status=EffectStatus.UNDECIDED, reason=reason)


def _row_of(rows: Sequence[EffectRow], effect: str) -> EffectRow | None:
    return next((r for r in rows if r.signature.effect == effect), None)


def _evidence_row(row: EffectRow, blocks: int, written: Written) -> tuple[str, ...]:
    factor, unit = handy_unit(row.size.value, row.signature.unit)
    verdict = str(row.status).replace("_", " ")
    if row.reason.startswith(AS_GOOD):
        others = row.reason.removeprefix(AS_GOOD).split(", ")
        verdict += f": as good as {', '.join(map(words, others))}"
    elif row.status is EffectStatus.UNDECIDED and not possible(row):
        verdict += ": size not possible"
    return (
        words(row.signature.effect),
        written.named(row.signature) or where_of(row.signature),
        verdict,
        with_interval(scaled(row.size, factor), unit) if np.isfinite(row.size.low) else "–",
        _size(factor * row.smallest, unit),
        _size(factor * row.detectable, unit),
        share_text(of_rms(row.gain), sign=True),
        f"{row.blocks_better} of {blocks}",
        number(row.p, 2),
        f"{100 * row.visible:.0f} %",
    )


def of_rms(gain: float) -> float:
    """The share of the RMS error that goes where such a share of the squared error does."""
    return 1.0 - float(np.sqrt(1.0 - min(gain, 1.0)))


def _size(value: float, unit: str) -> str:
    return f"{number(value, 2)} {unit}".rstrip(" -") if np.isfinite(value) else "–"


def untested_sheet(found: Investigation, untested: Mapping[str, str]) -> Sheet:
    """What could not be tested, and why."""
    rows = [
        (words(r.signature.effect), where_of(r.signature), r.reason)
        for r in found.rounds[-1].effects
        if r.status is EffectStatus.NOT_TESTABLE
    ]
    rows += [(words(effect), "", reason) for effect, reason in _not_looked_for(found, untested)]
    return Sheet("What could not be tested", ("effect", "where", "why"), rows or [("–", "–", "–")])

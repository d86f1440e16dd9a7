"""The evidence table: one row per effect, and what could not be tested."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectRow, EffectStatus
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.words import with_interval, words


def evidence_sheet(found: Investigation, untested: Mapping[str, str]) -> Sheet:
    """One row per effect of the table, by gain; greyed: not testable, and why."""
    rows: list[tuple[str, ...]] = []
    greyed = set()
    for row in table_rows(found):
        if row.status is EffectStatus.NOT_TESTABLE:
            greyed.add(len(rows))
        rows.append(_evidence_row(row))
    for effect, reason in [(e.effect, e.reason) for e in found.problem.excluded] + list(
        untested.items()
    ):
        greyed.add(len(rows))
        rows.append((words(effect), "–", "–", "–", "–", "–", "–", "not testable", reason))
    return Sheet(
        "Evidence",
        ("effect", "where", "size [95 %]", "matters from", "visible", "p", "held-out gain",
         "status", "why"),
        rows,
        note="Gain: reduction of the squared error on blocks the effect was not fitted to. "
        "Visible: share of the effect that the calibration cannot absorb. p: family-wise over the "
        "whole table, from sign flips of whole blocks.",
        greyed=frozenset(greyed),
    )  # fmt: skip


def table_rows(found: Investigation) -> list[EffectRow]:
    """Rows of named effects as they were accepted, the others beside the extended model."""
    named = {f.cause.signature.effect: f for f in found.found}
    rows: list[EffectRow] = []
    seen = set()
    for diagnosis in found.rounds:
        for row in diagnosis.effects:
            name = row.signature.effect
            if name in named and name not in seen and row.signature == named[name].cause.signature:
                from dataclasses import replace

                rows.append(replace(row, size=named[name].cause.size))
                seen.add(name)
    rivals = {r.effect for f in found.found for r in f.cause.rivals}
    for row in found.rounds[0].effects:
        if row.signature.effect in rivals and row.signature.effect not in seen:
            rows.append(row)
            seen.add(row.signature.effect)
    rows += [r for r in found.rounds[-1].effects if r.signature.effect not in seen]
    return sorted(rows, key=lambda r: (r.status is EffectStatus.NOT_TESTABLE, -r.gain))


def _evidence_row(row: EffectRow) -> tuple[str, ...]:
    tested = row.status is not EffectStatus.NOT_TESTABLE
    unit = row.signature.unit
    return (
        words(row.signature.effect),
        row.signature.where,
        with_interval(row.size, unit) if np.isfinite(row.size.low) else "–",
        f"{number(row.smallest, 2)} {unit}".rstrip(" -") if np.isfinite(row.smallest) else "–",
        f"{100 * row.visible:.0f} %",
        number(row.p, 2) if tested else "–",
        f"{100 * row.gain:+.1f} %".replace("-", "−") if tested else "–",
        str(row.status).replace("_", " "),
        row.reason,
    )


def untested_sheet(found: Investigation, untested: Mapping[str, str]) -> Sheet:
    """What could not be tested, and why."""
    rows = [
        (words(r.signature.effect), r.reason, "")
        for r in found.rounds[-1].effects
        if r.status is EffectStatus.NOT_TESTABLE
    ]
    rows += [(words(e.effect), e.reason, "") for e in found.problem.excluded]
    rows += [(words(name), reason, "") for name, reason in untested.items()]
    return Sheet("What could not be tested", ("effect", "why", ""), rows or [("–", "–", "")])

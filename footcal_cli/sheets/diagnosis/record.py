"""``diagnosis.json``."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectRow, EffectStatus
from footcal_cli.core.diagnosis.gain import main_gain
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.evidence import Interval
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.written import Written
from footcal_cli.intake.cases.shared import CaseRead
from footcal_cli.records.diagnosis import (
    CauseRecord,
    DiagnosisRecord,
    EffectRowRecord,
    HeldOutGain,
    RangeRecord,
)
from footcal_cli.sheets.diagnosis.contract import Answer
from footcal_cli.sheets.diagnosis.evidence import table_rows
from footcal_cli.sheets.diagnosis.experiment import experiment_words
from footcal_cli.sheets.diagnosis.held import held_by
from footcal_cli.sheets.diagnosis.words import matters, remedy_of


def record_of(
    found: Investigation, answer: Answer, read: CaseRead, rules: Rules, seed: int
) -> DiagnosisRecord:
    """``diagnosis.json``."""
    last = found.rounds[-1].before
    first = found.rounds[0].before
    rows = [_row_record(row, found.case.written) for row in table_rows(found)]
    rows += [
        _absent_record(name, reason)
        for name, reason in [
            *((e.effect, e.reason) for e in found.problem.excluded),
            *read.untested.items(),
        ]
    ]
    return DiagnosisRecord(
        experiment_kind=found.case.experiment.name,
        verdict=found.verdict.value,
        sentence=answer.verdict.sentence,
        holds=held_by(found.case),
        causes=tuple(_cause_record(found, item) for item in found.found),
        rivals=answer.rivals,
        experiment=experiment_words(answer.experiment),
        next_experiment=answer.experiment,
        ranges=_ranges(found),
        findings=tuple(read.findings),
        effects=tuple(rows),
        blocks=found.problem.blocks,
        rows=int(found.problem.residual.size),
        smallest_p=found.rounds[0].smallest_p,
        share_explained=None if not found.found else 1.0 - last.ceiling,
        leftover_p=last.p,
        evidence={
            "signals_p": first.bump_p,
            "flexible_p": first.flexible_p,
            "line_p": first.line_p,
            "between_p": first.between_p,
            "spell_p": first.spell_p,
            "curve_p": first.curve.p,
            "ceiling": first.ceiling,
        },
        seed=seed,
        rules=rules.listed(),
    )


def _ranges(found: Investigation) -> dict[str, RangeRecord]:
    """Every fitted parameter of the named causes; none where nothing was named."""
    return {
        name: RangeRecord(
            mean=interval.value, sd=(interval.high - interval.low) / 4.0,
            low=interval.low, high=interval.high, unit=units[name.rsplit(".", 1)[1]],
        )
        for item in found.found
        for units in [item.units]
        for name, interval in zip(item.parameter_names, item.intervals, strict=True)
        if np.isfinite(interval.low) and np.isfinite(interval.high)
    }  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _pair(interval: Interval) -> tuple[float, float] | None:
    if not np.isfinite(interval.low) or not np.isfinite(interval.high):
        return None
    return interval.low, interval.high


def _cause_record(found: Investigation, item: Found) -> CauseRecord:
    cause, signature = item.cause, item.cause.signature
    gain = main_gain(found.gains, found.problem)
    shape = {
        name.rsplit(".", 1)[1]: interval.value
        for name, interval in zip(item.parameter_names, item.intervals, strict=True)
        if not name.endswith(f".{signature.parameter}")
    } | dict(item.placed)
    return CauseRecord(
        effect=signature.effect,
        where=signature.where,
        parameter=signature.parameter,
        size=cause.size.value,
        sd=_finite((cause.size.high - cause.size.low) / 4.0),
        unit=signature.unit,
        ci95=_pair(cause.size),
        shape=shape,
        p=cause.p,
        held_out_gain=None
        if gain is None
        else HeldOutGain(
            quantity=gain.output, unit=gain.unit, before=gain.before, after=gain.after,
            ci95=_pair(gain.change),
        ),
        # the same blocks as in the sentence: of the quantity that the gain is quoted for
        blocks_better=cause.blocks_better if gain is None else gain.better_blocks,
        rivals=tuple(dict.fromkeys(r.effect for r in cause.rivals)),
        places=tuple(dict.fromkeys(s.where for s in cause.places)),
        probability=cause.probability,
        matters=matters(found, item),
        remedy=remedy_of(found, item),
        written=found.case.written.named(signature),
    )  # fmt: skip


def _row_record(row: EffectRow, written: Written) -> EffectRowRecord:
    signature: Signature = row.signature
    tested = row.status is not EffectStatus.NOT_TESTABLE
    return EffectRowRecord(
        effect=signature.effect,
        where=signature.where,
        parameter=signature.parameter,
        unit=signature.unit,
        size=_finite(row.size.value) if tested else None,
        ci95=_pair(row.size) if tested else None,
        smallest_that_matters=_finite(row.smallest),
        detectable=_finite(row.detectable),
        visible=row.visible,
        p=row.p if tested else None,
        gain=row.gain if tested else None,
        informative_blocks=row.informative,
        status=row.status.value,
        reason=row.reason,
        written=written.named(signature),
    )


def _absent_record(name: str, reason: str) -> EffectRowRecord:
    return EffectRowRecord(
        effect=name, where="", parameter="", unit="", size=None, ci95=None,
        smallest_that_matters=None, detectable=None, visible=None, p=None, gain=None,
        informative_blocks=None, status="not_testable", reason=reason,
    )  # fmt: skip

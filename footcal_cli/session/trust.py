"""Whether a fit may be called good: an absolute look at what it left."""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.records.results import FindingRecord, RmseRow
from footcal_cli.report.outcome import Outcome

UNTRUSTED = frozenset(
    {
        "worse_than_before", "scale_off_nameplate", "dead_cell", "turned_sign",
        "exchanged_channels", "duplicate_channel", "transducer_turned", "axis_turned",
        "negative_leg_weight", "forces_unexplained", "com_far", "loads_off_calibration",
        "leg_weight_off_recipe", "total_force_off_weight",
    }
)  # fmt: skip
"""Findings with which no calibration of these data means anything."""
DOUBTFUL = frozenset(
    {
        "legs_very_light", "negative_loads", "no_load", "calibration_of_another_robot",
        "unknown_sign_convention", "turned_sign", "time_goes_back",
    }
)  # fmt: skip
"""Warnings about units, signs and robots: what rests on them may be meaningless, so not good."""
WORSE = 1.25
"""Ratio of an error after to that before from which a quantity got worse."""
SHARE = 0.1
"""And by this share of the largest error before among quantities of its unit."""
LEAST = {"N": 0.05, "m": 5e-4, "Nm": 5e-3}
"""And by so much at least: what is smaller does not matter."""


def trusted(outcome: Outcome) -> Outcome:
    """The outcome of a calibration with its doubts: not good and not usable where they weigh."""
    if outcome.parameters is None or outcome.diagnosis is not None:
        return outcome
    report = outcome.report
    findings = (*report.findings, *_worse(outcome))
    doubted = any(f.code in UNTRUSTED and f.severity == "alarm" for f in findings)
    verdict = report.verdict
    if doubted or (not outcome.usable and verdict.level == "good"):
        verdict = verdict.model_copy(update={"level": "bad"})
    return replace(
        outcome,
        report=replace(report, findings=findings, verdict=verdict),
        usable=outcome.usable and not doubted,
    )


def _worse(outcome: Outcome) -> list[FindingRecord]:
    """Quantities that the calibration left worse than before, whatever the others gained."""
    rows = outcome.rmse.rows if outcome.rmse is not None else ()
    before = {_key(row): row for row in rows if row.stage == "before"}
    largest = {
        unit: max(row.rmse for row in before.values() if row.unit == unit)
        for unit in {row.unit for row in before.values()}
    }
    known = {row.reference for row in before.values()} - {"baseline"}
    judged = {outcome.reference} & known or known
    found = []
    for row in rows:
        was = before.get(_key(row))
        if row.stage != outcome.stage or was is None:
            continue
        # another calibration is something to compare with, not what is true
        if row.reference not in judged:
            continue
        gained = row.rmse - was.rmse
        floor = max(LEAST.get(row.unit, 0.0), SHARE * largest[row.unit])
        if row.rmse > WORSE * was.rmse and gained > floor:
            found.append(
                FindingRecord(
                    code="worse_than_before", severity="alarm", where=row.quantity,
                    sentence=f"the calibration made it worse: RMSE {was.rmse:.3g} → "
                    f"{row.rmse:.3g} {row.unit} against {row.reference} "
                    f"({row.split.replace('_', ' ')})",
                    remedy="do not use it; check the recipe against the log (footcal check), then "
                    "run footcal diagnose",
                )
            )  # fmt: skip
    return found


def _key(row: RmseRow) -> tuple[str, str, str]:
    return row.quantity, row.reference, row.split

"""Errors with the extended model, and how it changes the calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.inference.whitening import longest_memory
from footcal_cli.records.display_units import display_unit
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.words import share_interval, share_text


def gain_sheets(found: Investigation) -> tuple[Sheet, ...]:
    """Held-out errors before and after, per output."""
    if not found.found:
        return ()
    rows = [
        (
            gain.output, number(gain.before, 3), number(gain.after, 3), gain.unit,
            f"{share_text(gain.change.value)} "
            f"{share_interval(gain.change.low, gain.change.high)}",
            f"{int(np.sum(gain.per_block[:, 1] < gain.per_block[:, 0]))} of {len(gain.per_block)}",
        )
        for gain in found.gains
    ]  # fmt: skip
    return (
        Sheet(
            "Errors of the extended model on data it was not fitted to",
            ("output", "before", "after", "unit", "reduction [95 %]", "blocks better"),
            rows,
            note=f"Each block is predicted by a fit to the others. Repeating the choice of the "
            f"effect without single blocks gives the same effect in {100 * found.stable:.0f} % of "
            "the folds.",
        ),
    )


def movement_sheets(moved: Sequence[Movement]) -> tuple[Sheet, ...]:
    """Calibration before and after."""
    if not moved:
        return ()
    scales = [m.after for m in moved if m.unit == "N/count"]
    rows = []
    for m in moved:
        factor, unit = display_unit(m.unit, scales)
        rows.append(
            (m.name, number(factor * m.before, 6), number(factor * m.after, 6), unit,
             f"{m.in_sd:+.1f}".replace("-", "−"))
        )  # fmt: skip
    return (
        Sheet(
            "What the calibration does when the effects enter the model",
            ("parameter", "without", "with", "unit", "moved (sd)"),
            rows,
            note="A parameter that moves by many sd had been carrying the effect.",
        ),
    )


def method_note(found: Investigation, seed: int) -> str:
    """How the evidence was counted."""
    first = found.rounds[0]
    tau = longest_memory(found.problem)
    rate = found.problem.rate_hz
    time = f"{number(tau / rate, 2)} s" if rate > 0 else f"{number(tau, 2)} rows"
    return (
        f"{found.problem.blocks} blocks, {found.problem.residual.size} rows; the residual's "
        f"autocorrelation time is {time}; smallest reachable p {number(first.smallest_p, 2)}; "
        f"seed {seed}. Rows are never counted as evidence, blocks are."
    )

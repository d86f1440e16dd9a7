"""`static-init` on feet with six-axis transducers: the report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.stances import StanceRows
from footcal_cli.core.static_init import SixAxisInit
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets import stand as sheets

_NOTE = (
    "Offsets are subtracted from the readings; mass, CoM and weights come on top of the recipe's. "
    "Estimated: standing at least halved the sd. The others keep their prior."
)


def outcome_of(
    robot: str, rows: StanceRows, fit: SixAxisInit, quiet: Sequence[QuietSet]
) -> Outcome:
    """Offsets of six-axis feet as far as standing shows them."""
    estimates, seen = fit.estimates, fit.observability
    known = sum(status == "estimated" for status in estimates.status)
    stances = sum(one.stances for one in quiet)
    everything = known == len(estimates.status)
    output, unsure = np.array(rows.output), np.hypot(rows.sd, np.linalg.norm(rows.shared, axis=1))
    return Outcome(
        title=f"Standing calibration of {robot}",
        verdict=VerdictRecord(
            level="good" if everything else "warning",
            sentence=f"{sheets.counted(stances)} {seen.rank} of "
            f"{seen.unknowns} unknowns of six-axis feet; {known} estimated, the others keep "
            "their prior.",
            details=(
                "With both feet down only sums over the feet are seen: lift each foot once, or "
                "walk (online-replay), to distinguish their offsets.",
                f"Not seen: {'; '.join(seen.weakest(3))}.",
            ),
        ),
        pictures=(
            sheets.beliefs_picture(
                rows, estimates.values, estimates.sd, estimates.status,
                "Offsets against the prior of zero; hollow ones are not observable from standing.",
            ),
            sheets.directions_picture(seen),
        ),
        sheets=(
            sheets.beliefs_sheet(
                rows.names, rows.units, estimates.values, estimates.sd, rows.prior_sd,
                estimates.status, _NOTE,
            ),
            sheets.directions_sheet(seen),
        ),
        footer=(f"chi² {fit.chi2:.3g} for {fit.dof} rows.",),
        rmse=sheets.offset_rmse_of(rows, estimates.values, quiet),
        reference_sd={
            name: float(np.min(unsure[output == name])) for name in dict.fromkeys(rows.output)
        },
    )  # fmt: skip

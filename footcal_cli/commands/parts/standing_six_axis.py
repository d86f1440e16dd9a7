"""`static-init` on feet with six-axis transducers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footcal_cli.commands.static_init import StaticInitOptions
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.session.session import Outcome, Session


def standing_on_six_axis(
    session: Session[StaticInitOptions], recordings: Sequence[Recording]
) -> Outcome:
    """Offsets of six-axis feet as far as standing shows them."""
    import numpy as np

    from footcal_cli.commands.parts.feet_parameters import feet_parameters
    from footcal_cli.commands.parts.stances import (
        all_stances,
        standing_findings,
    )
    from footcal_cli.core.static_init import fit_static_six_axis, six_axis_stance_rows
    from footcal_cli.plots.stand import plot_beliefs, plot_directions
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.report import Picture, Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets import stand as sheets

    with session.step("fit"):
        rows, quiet = all_stances(
            session,
            recordings,
            lambda recording, chosen: six_axis_stance_rows(recording.merged.log, chosen),
        )
        fit = fit_static_six_axis(rows)
    known = sum(status == "estimated" for status in fit.estimates.status)
    seen = fit.observability
    stances = sum(one.stances for one in quiet)
    everything = known == len(fit.estimates.status)
    return Outcome(
        report=Report(
            title=f"Standing calibration of {session.recipe.robot.name}",
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
                Picture(
                    "beliefs",
                    lambda: plot_beliefs(
                        rows.names, rows.units, rows.prior_sd, fit.estimates.values,
                        fit.estimates.sd, [s == "estimated" for s in fit.estimates.status],
                    ),
                    "Offsets against the prior of zero; grey ones are not observable from "
                    "standing.",
                    title="Each parameter before and after standing",
                ),
                Picture(
                    "directions", lambda: plot_directions(seen.singular_values, seen.rank),
                    "How well each direction is seen.",
                    title="How well each parameter direction is observed",
                ),
            ),
            sheets=(
                sheets.beliefs_sheet(
                    rows.names, rows.units, fit.estimates.values, fit.estimates.sd, rows.prior_sd,
                    fit.estimates.status, sheets.SIX_AXIS_NOTE,
                ),
                sheets.directions_sheet(seen),
            ),
            findings=standing_findings(recordings, (fit.chi2, fit.dof)),
            footer=(f"chi² {fit.chi2:.3g} for {fit.dof} rows.",),
        ),
        rmse=sheets.offset_rmse_of(rows, np.asarray(fit.estimates.values), quiet),
        parameters=feet_parameters(session, fit.estimates),
    )  # fmt: skip

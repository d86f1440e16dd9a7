"""``footcal static-init``: scale and bias of foot cells from quiet standing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import StaticInitOptions

if TYPE_CHECKING:
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(StaticInitOptions)
def static_init(session: Session[StaticInitOptions]) -> Outcome:
    """Find scales and biases of foot cells as far as quiet standing shows them."""
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.intake.recordings import is_six_axis_robot, read_recordings

    options = session.options
    rule = MergeRule(
        delay_s=options.delay_s, cutoff_hz=options.cutoff_hz, min_force_n=options.min_force_n
    )
    with session.step("read"):
        recordings = read_recordings(
            session, rule, "stand", body_needed=is_six_axis_robot(session.recipe.robot)
        )
    on_transducers = recordings[0].belief is None
    return (_on_transducers if on_transducers else _on_cells)(session, recordings)


def _on_cells(session: Session[StaticInitOptions], recordings: Sequence[Recording]) -> Outcome:
    from dataclasses import replace
    from pathlib import Path

    import numpy as np

    from footcal_cli.core.checks.gain_apart import check_gain_apart
    from footcal_cli.core.next_stance import stance_curve
    from footcal_cli.core.online.weighed import as_unsure_as_weighed, weighed_standing
    from footcal_cli.core.plausibility import check_gains
    from footcal_cli.core.stances import stance_rows
    from footcal_cli.core.static_init import fit_static, stance_errors
    from footcal_cli.errors import DataError
    from footcal_cli.intake.stances import all_stances, next_menu
    from footcal_cli.session.calibration import feet_calibration
    from footcal_cli.sheets.stand_on_cells import outcome_of
    from footcal_cli.sheets.streams import standing_findings

    options, robot = session.options, session.recipe.robot
    belief = recordings[0].belief
    assert belief is not None, "looked at by the caller"
    with session.step("fit"):
        rows, quiet = all_stances(
            options,
            recordings,
            lambda recording, chosen: stance_rows(
                recording.merged.log, chosen, belief, force_sd_n=options.force_sd_n,
                moment_sd_nm=options.moment_sd_nm, swing_sd_n=options.lifted_sd_n,
                com_sd_m=options.com_sd_m,
            ),
        )  # fmt: skip
        weight_n = robot.weight_n or 1.0
        total = np.array([name == "fz" for name in rows.output])
        if not total.any():
            raise DataError(
                "no foot is on the ground in any stance: nothing carries the weight of "
                f"{weight_n:.0f} N", file=Path(recordings[0].name),
                remedy="record the robot standing, or correct mass_kg and the units of the cells",
            )  # fmt: skip
        fit = fit_static(rows, belief)
        errors = stance_errors(rows, belief, weight_n)
        curve = stance_curve(rows, belief, weight_n)
        menu = next_menu(recordings, quiet, rows, weight_n)
        weighed = weighed_standing(
            rows.h[total], rows.error[total], rows.sd[total],
            rows.prior_correlation, weight_n, robot.mass_kg or 1.0,
        )  # fmt: skip
        weighed = replace(weighed, stated_sd_kg=robot.mass_sd_kg)
    session.note(weighed.findings())
    session.note(check_gains(belief.channels, fit.gain))
    c = len(belief.channels)
    prior = rows.prior_correlation * np.outer(rows.prior_sd, rows.prior_sd)
    session.note(check_gain_apart(belief.channels, fit.gain, fit.covariance[:c, :c], prior[:c, :c]))
    found = outcome_of(robot.name, rows, fit, errors, quiet, curve, menu, weighed)
    session.note(standing_findings(recordings, fit.chi2, fit.dof))
    # standing, a wrong mass goes into zeros as well: into scales as far as the fit takes it there
    estimates = as_unsure_as_weighed(
        fit.estimates, weighed.shared_sd(robot.mass_share_sd), weight_n * fit.per_newton
    )
    # a force is judged by the stated weight, which is as unsure as the mass
    unsure = {**found.reference_sd, "vgrf": weight_n * robot.mass_share_sd}
    return replace(
        found, parameters=feet_calibration(session, estimates), reference_sd=unsure
    )  # fmt: skip


def _on_transducers(
    session: Session[StaticInitOptions], recordings: Sequence[Recording]
) -> Outcome:
    from dataclasses import replace

    from footcal_cli.core.stances import six_axis_stance_rows
    from footcal_cli.core.static_init import fit_static_six_axis
    from footcal_cli.intake.stances import all_stances
    from footcal_cli.session.calibration import feet_calibration
    from footcal_cli.sheets.stand_on_transducers import outcome_of
    from footcal_cli.sheets.streams import standing_findings

    with session.step("fit"):
        rows, quiet = all_stances(
            session.options,
            recordings,
            lambda recording, chosen: six_axis_stance_rows(
                recording.merged.log, chosen, session.recipe.robot.mass_share_sd
            ),
        )
        fit = fit_static_six_axis(rows)
    found = outcome_of(session.recipe.robot.name, rows, fit, quiet)
    session.note(standing_findings(recordings, fit.chi2, fit.dof))
    return replace(found, parameters=feet_calibration(session, fit.estimates))

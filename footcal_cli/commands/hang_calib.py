"""``footcal hang-calib``: offsets, leg weight and leg CoM of hanging legs ([Wu], III-A)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import HangCalibOptions

if TYPE_CHECKING:
    from footcal_cli.core.log import Log
    from footcal_cli.core.parameters import Estimates
    from footcal_cli.core.study.stepwise import StepwiseFit
    from footcal_cli.records.results import ParametersRecord
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(HangCalibOptions)
def hang_calib(session: Session[HangCalibOptions]) -> Outcome:
    """Fit offsets of six-axis transducers, and weight and CoM of leg or tool below."""
    session.refuse_missing_logs("hang")
    from dataclasses import replace

    from footcal_cli.core.hang.joint import fit_hang
    from footcal_cli.core.hang.runs import hang_runs
    from footcal_cli.core.plausibility import check_leg_weights
    from footcal_cli.core.pose.turned import hanging_axes
    from footcal_cli.intake.hang import hang_options, leg_logs
    from footcal_cli.session.calibration import counted_together
    from footcal_cli.sheets.hang import chosen_estimates, outcome_of
    from footcal_cli.tables.columns import hang_table

    options, robot = session.options, session.recipe.robot
    with session.step("read"):
        tables = session.read_required(hang_table())
        logs, rejected = leg_logs(tables, session.recipe, options, session.parameters)
        runs = {leg: hang_runs(log)[0] for leg, log in logs.items()}
    with session.step("fit"):
        asked = hang_options(options, session.recipe, tables)
        fits = {leg: fit_hang(log, asked) for leg, log in logs.items()}
        session.note(hanging_axes(logs, fits, asked))
    with session.step("compare"):
        others = _others(options, logs)
    chosen = chosen_estimates(fits, others, options.method)
    weights = {leg: float(one[f"{leg}.weight"]) for leg, one in chosen.items()}
    stated = {n: leg.mass_kg * robot.gravity_mps2 for n, leg in robot.legs.items() if leg.mass_kg}
    session.note(check_leg_weights(weights, robot.weight_n, stated))
    found = outcome_of(robot.name, fits, runs, others, options.method, rejected)
    tilts = {f"{leg}.{name}" for leg, fit in fits.items() for name in fit.model.tilt_names()}
    together = counted_together(session, list(chosen.values()), tilts)
    return replace(
        found, parameters=_parameters(session, dict(zip(chosen, together, strict=True)), logs)
    )


def _others(
    options: HangCalibOptions, logs: Mapping[str, list[Log]]
) -> dict[str, dict[str, StepwiseFit]]:
    """The naive method, which is the error before, and if asked for the stepwise one.

    Empty where the orientations do not come in two opposite pairs.
    """
    from footcal_cli.core.study.stepwise import fit_stepwise
    from footcal_cli.errors import FitError

    methods = ["naive"]
    if options.compare or options.method == "stepwise":
        methods.append("stepwise")
    try:
        return {
            method: {leg: fit_stepwise(log, naive=method == "naive") for leg, log in logs.items()}
            for method in methods
        }
    except FitError:
        if options.method == "joint":
            return {}
        raise


def _parameters(
    session: Session[HangCalibOptions],
    chosen: Mapping[str, Estimates],
    logs: Mapping[str, Sequence[Log]],
) -> ParametersRecord:
    import numpy as np

    from footcal_cli.records.results import Range
    from footcal_cli.session.calibration import LEGS, calibration

    ranges: dict[str, dict[str, Range]] = {}
    for leg in chosen:
        force = np.concatenate([np.linalg.norm(log.readings[:, :3], axis=1) for log in logs[leg]])
        ranges[leg] = {"force": Range.of(force, "N")}
        warmth = [w for log in logs[leg] if (w := log.known.get("temperature_degc")) is not None]
        if warmth:
            ranges[leg]["temperature"] = Range.of(np.concatenate(warmth), "degC")
    return calibration(session, LEGS, *chosen.values(), fitted_range=ranges)

"""Hanging legs as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.effects import calibration_of, having
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.experiments.hang import EXPERIMENT
from footcal_cli.core.hang.dead_axis import dead_axes
from footcal_cli.core.hang.effect import hanging_effect
from footcal_cli.core.hang.joint import HangFit, fit_hang
from footcal_cli.core.hang.runs import RUN, are_held, blocked, hang_runs
from footcal_cli.core.hang.words import hanging_thing
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import Parameter, ParameterSet
from footcal_cli.core.plausibility import check_leg_weights
from footcal_cli.core.pose.turned import hanging_axes
from footcal_cli.intake.cases.shared import CaseRead, baseline_of, chain_of, needs_time, of_cells
from footcal_cli.intake.hang import hang_options, leg_logs
from footcal_cli.recipe.options import DiagnoseOptions, HangCalibOptions
from footcal_cli.tables.columns import hang_table

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


FITTED = "weight, CoM and tilts are fitted to these very logs and take it up"


def unseen_hanging() -> dict[str, str]:
    """Effects that hanging logs do not test, and why."""
    taken = having(Trait.HUNG, Trait.MOUNTING, experiment=EXPERIMENT.name)
    return of_cells(EXPERIMENT) | dict.fromkeys(sorted(taken), FITTED)


def read(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per leg; a block is some turns of all legs in one hanging.

    The baseline is the joint fit of `hang-calib` to these very logs: how the robot hung askew is a
    matter of the recording, whatever calibration was given. Effects of an extended calibration
    stay in the model.
    """
    recipe = session.recipe
    asked = recipe.options_for(HangCalibOptions, "hang_calib")
    tables = session.read_required(hang_table())
    raw, _ = leg_logs(tables, recipe, asked)
    undone, _ = leg_logs(tables, recipe, asked, session.parameters)
    # terms in temperature and time are effects here
    constant = asked.model_copy(update={"temperature": False, "drift": False})
    options = hang_options(constant, recipe, tables)
    fits = {leg: fit_hang(logs, options) for leg, logs in undone.items()}
    logs, in_order = blocked(raw)
    weight_n = sum(abs(fit.values.weight_n) for fit in fits.values()) / len(fits)
    chain, values, free = _model(session, fits, logs)
    case = Case(
        experiment=EXPERIMENT,
        logs=logs,
        chain=chain,
        values=values,
        calibration=ParameterSet(free),
        tolerance_n=session.options.tolerance_n or 0.005 * weight_n,
        tolerance_nm=session.options.tolerance_mm / 1000.0 * weight_n,
        alike=False,
        stride=max(sum(len(log) for log in logs) // MOST_SAMPLES, 1),
        shared_blocks=True,
        setting_key=RUN if are_held(logs) else "",
    )
    untested = unseen_hanging()
    if not in_order:
        untested |= needs_time(EXPERIMENT, "time stamps start anew in every hanging")
    weights = {leg: fit.values.weight_n for leg, fit in fits.items()}
    found = hanging_axes(undone, fits, options) + check_leg_weights(weights, None)
    thing = hanging_thing({leg: fit.model.order for leg, fit in fits.items()})
    found += dead_axes({leg: hang_runs(own)[0] for leg, own in undone.items()}, thing)
    return CaseRead(case, found, untested)


MOST_SAMPLES = 2_000
"""Samples of all legs together at which the residual is judged, about."""


def _model(
    session: Session[DiagnoseOptions], fits: Mapping[str, HangFit], logs: Sequence[Log]
) -> tuple[Chain, dict[str, float], tuple[Parameter, ...]]:
    """Chain, its values, and what of it is calibrated."""
    channels = tuple(c for log in logs for c in log.channels)
    chain, values = chain_of(baseline_of(session), channels, (calibration_of(channels).name,))
    free: list[Parameter] = []
    for leg, fit in fits.items():
        chain = chain.with_link(Link(hanging_effect(fit.model), {leg: (leg,)}))
        found = fit.estimates
        values |= dict(zip(found.names, found.values.tolist(), strict=True))
        free += [replace(p, value=values[p.name]) for p in fit.model.parameters(0.0)]
    return chain, values, tuple(free)

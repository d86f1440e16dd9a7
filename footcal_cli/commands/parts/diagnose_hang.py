"""Hanging legs as the case that `diagnose` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footcal_cli.commands.diagnose import DiagnoseOptions
    from footcal_cli.commands.hang_calib import HangCalibOptions
    from footcal_cli.commands.parts.diagnose_cases import CaseRead
    from footcal_cli.core.chain import Chain
    from footcal_cli.core.hang.joint import HangFit
    from footcal_cli.core.log import Log
    from footcal_cli.core.parameters import Parameter
    from footcal_cli.session.session import Session

FITTED = "weight, CoM and tilts are fitted to these very logs and take it up"


def unseen_hanging() -> dict[str, str]:
    """Effects that hanging logs do not test, and why."""
    from footcal_cli.commands.parts.diagnose_cases import of_cells
    from footcal_cli.core.effects import having
    from footcal_cli.core.effects.contract import Trait
    from footcal_cli.core.experiments.hang import EXPERIMENT

    taken = having(Trait.HUNG, Trait.MOUNTING, experiment=EXPERIMENT.name)
    return of_cells(EXPERIMENT) | dict.fromkeys(sorted(taken), FITTED)


def read_hang(session: Session[DiagnoseOptions]) -> CaseRead:
    """One log per leg; a block is some turns of all legs in one hanging.

    The baseline is the joint fit of `hang-calib` to these very logs: how the robot hung askew is a
    matter of the recording, whatever calibration was given. Effects of an extended calibration
    stay in the model.
    """
    from footcal_cli.commands.hang_calib import HangCalibOptions, asked_of, hanging_axes
    from footcal_cli.commands.parts.diagnose_cases import CaseRead, needs_time
    from footcal_cli.commands.parts.hang_logs import leg_logs
    from footcal_cli.core.experiments.hang import EXPERIMENT
    from footcal_cli.core.hang.blocks import blocked
    from footcal_cli.core.hang.joint import fit_hang
    from footcal_cli.core.hang.runs import hang_runs
    from footcal_cli.core.inference.case import Case
    from footcal_cli.core.parameters import ParameterSet
    from footcal_cli.recipe import validated
    from footcal_cli.tables.columns import hang_table

    recipe = session.recipe
    asked = validated(
        HangCalibOptions, recipe.options.get("hang_calib", {}), file=recipe.path, table="hang_calib"
    )
    tables = session.read_required(hang_table())
    raw, _ = leg_logs(tables, recipe, asked.orientation_of, asked.leg_weight_n)
    undone, _ = leg_logs(
        tables, recipe, asked.orientation_of, asked.leg_weight_n, session.parameters
    )
    fits = {
        leg: fit_hang(logs, asked_of(_constant(asked), recipe.robot.gravity_mps2))
        for leg, logs in undone.items()
    }
    logs, in_order = blocked(raw)
    weight_n = sum(fit.values.weight_n for fit in fits.values()) / len(fits)
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
        settings="hanging",
    )
    untested = unseen_hanging()
    if not in_order:
        untested |= needs_time(EXPERIMENT, "time stamps start anew in every hanging")
    runs = {leg: hang_runs(each)[0] for leg, each in undone.items()}
    turned = hanging_axes(undone, runs, fits, asked_of(_constant(asked), recipe.robot.gravity_mps2))
    return CaseRead(case, turned, untested)


MOST_SAMPLES = 2_000
"""Samples of all legs together at which the residual is judged, about."""


def _constant(asked: HangCalibOptions) -> HangCalibOptions:
    """Without terms in temperature and time: those are effects here."""
    return asked.model_copy(update={"temperature": False, "drift": False})


def _model(
    session: Session[DiagnoseOptions], fits: Mapping[str, HangFit], logs: Sequence[Log]
) -> tuple[Chain, dict[str, float], tuple[Parameter, ...]]:
    """Chain, its values, and what of it is calibrated."""
    from dataclasses import replace

    from footcal_cli.commands.parts.diagnose_cases import baseline_of, chain_of
    from footcal_cli.core.chain import Link
    from footcal_cli.core.effects import calibration_of
    from footcal_cli.core.hang.effect import hanging_effect

    channels = tuple(c for log in logs for c in log.channels)
    chain, values = chain_of(baseline_of(session), channels, (calibration_of(channels).name,))
    free: list[Parameter] = []
    for leg, fit in fits.items():
        chain = chain.with_link(Link(hanging_effect(fit.model), {leg: (leg,)}))
        found = fit.estimates
        values |= dict(zip(found.names, found.values.tolist(), strict=True))
        free += [replace(p, value=values[p.name]) for p in fit.model.parameters(0.0)]
    return chain, values, tuple(free)

"""One simulated recording session: a robot, an experiment, the effects asked for, a seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Chain, chain_of, link
from footcal_cli.core.effects.calibration import AXES, OFFSET, SCALE_BIAS
from footcal_cli.core.effects.contract import Effect, units_of
from footcal_cli.core.effects.six_axis import MOUNT_ROTATION, MOUNT_TRANSLATION
from footcal_cli.core.effects.six_axis_beliefs import HANG_TILT, HANGINGS
from footcal_cli.core.log import ExperimentName, Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.ankle_logs import ankle_logs
from footcal_cli.core.simulation.bench_logs import placements_log, weights_logs
from footcal_cli.core.simulation.biped_logs import (
    BipedLogs,
    Course,
    MotionAt,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.columns import (
    Columns,
    ankle_body_columns,
    body_columns,
    cells_columns,
    hang_columns,
    loads_columns,
    placements_columns,
    poses_columns,
    weights_columns,
    wrenches_columns,
)
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    offset_values,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.measure import Simulated
from footcal_cli.core.simulation.noise import stream
from footcal_cli.core.simulation.plans import Plans, Spread
from footcal_cli.core.simulation.recorded import recorded
from footcal_cli.core.simulation.robots import Biped, Hexapod, HexapodLeg
from footcal_cli.errors import UsageError

_OFFSET_SHARE, _OFFSET_ARM_M = 0.01, 0.1
"""Sd of the offset of an ankle's forces, as a share of the weight, and what makes it a torque's."""
ON_FEET = ("weights", "placements", "stand", "walk")


@dataclass(frozen=True)
class EffectRequest:
    """An effect to put into a simulation.

    Parameters
    ----------
    owner
        The channel, foot or leg that carries it; None: every one of them alike.
    values
        Values by the parameter's short name; the others stay at neutral.
    """

    effect: Effect
    owner: str | None
    values: Mapping[str, float]


@dataclass(frozen=True)
class Scenario:
    """The logs of a simulated session, ready to be written, and everything that was true.

    Parameters
    ----------
    files
        File stem -> canonical columns.
    chain, values
        The effects and all their values by full parameter name.
    shown, truth
        One log as it was recorded and as it was, for pictures: readings in counts or N.
    """

    files: Mapping[str, Columns]
    chain: Chain
    values: Mapping[str, float]
    shown: Log
    truth: Log


def calibration(robot: Biped, spread: Spread, seed: int) -> tuple[Chain, dict[str, float]]:
    """Scales and biases of the simulated cells, drawn around the nameplate."""
    rng = stream(seed, "calibration")
    values: dict[str, float] = {}
    for channel in robot.channels:
        scale = robot.scale_n_per_count * (1.0 + spread.scale * rng.standard_normal())
        bias = -scale * robot.zero_counts + spread.bias_n * rng.standard_normal()
        values[f"{channel}.scale"], values[f"{channel}.bias"] = float(scale), float(bias)
    return chain_of([link(SCALE_BIAS, robot.channels)]), values


def ankle_offsets(robot: Biped, seed: int) -> tuple[Chain, dict[str, float]]:
    """Offsets of simulated ankle transducers, drawn as shares of the robot's weight."""
    rng = stream(seed, "ankle offsets")
    values: dict[str, float] = {}
    for foot in robot.feet:
        for axis in AXES:
            size = _OFFSET_SHARE * robot.weight_n
            size *= 1.0 if axis.startswith("f") else _OFFSET_ARM_M * robot.length
            values[f"{foot}.offset_{axis}"] = float(size * rng.standard_normal())
    return chain_of([link(OFFSET, robot.channels)]), values


def mounting(robot: Hexapod, spread: Spread, seed: int) -> tuple[Chain, dict[str, float]]:
    """Offsets, mounting errors and hanging tilts of the simulated transducers."""
    rng = stream(seed, "mounting")
    values = offset_values(robot)
    for name, leg in robot.legs.items():
        for axis in "xyz":
            values[f"{name}.mount_rot_{axis}"] = spread.mount_rotation_rad * rng.standard_normal()
            values[f"{name}.mount_pos_{axis}"] = spread.mount_translation_m * rng.standard_normal()
        values |= hang_tilts(name, leg, spread.hang_tilt_rad, seed)
    effects = (HANG_TILT, MOUNT_TRANSLATION, MOUNT_ROTATION, OFFSET)
    return chain_of([link(effect, robot.channels) for effect in effects]), values


def hang_tilts(name: str, leg: HexapodLeg, sd_rad: float, seed: int) -> dict[str, float]:
    """Tilts of a leg's hangings: the robot hangs as one, so all legs share the body's tilt.

    For a body axis b along gravity the robot turns by a small vector across b; the leg sees it
    in its own nominal axes.
    """
    rotation = np.array(leg.rotation_bt)
    tilts: dict[str, float] = {}
    for way, axis_t in HANGINGS.items():
        axis_b = np.round(rotation @ np.array(axis_t, dtype=float), 6) + 0.0
        turn_b = sd_rad * stream(seed, f"hanging {axis_b.tolist()}").standard_normal(3)
        turn_t = rotation.T @ (turn_b - (turn_b @ axis_b) * axis_b)
        tilts |= {
            f"{name}.tilt_{way}_{axis}": float(turn_t[i])
            for i, axis in enumerate("xyz")
            if axis != way[1]
        }
    return tilts


def with_effects(
    chain: Chain,
    values: Mapping[str, float],
    requests: Sequence[EffectRequest],
    channels: Sequence[str],
) -> tuple[Chain, dict[str, float]]:
    """A chain and its values extended by the effects asked for.

    Raises
    ------
    UsageError
        No such owner on this robot, a value out of bounds, or the effect named twice for one.
    """
    all_values = dict(values)
    for request in requests:
        effect = request.effect
        units = units_of(effect.scope, channels)
        owners = units if request.owner is None else (request.owner,)
        if request.owner is not None and request.owner not in units:
            raise UsageError(
                f"{effect.name}: no {effect.scope.value} named '{request.owner}'",
                remedy=f"name one of {', '.join(units)}",
            )
        if any(
            item.effect.name == effect.name and set(owners) & set(item.owners)
            for item in chain.links
        ):
            raise UsageError(f"{effect.name} is in the simulation twice", remedy="name it once")
        for p in effect.parameters:
            value = request.values.get(p.name, p.neutral)
            if not p.lower <= value <= p.upper:
                raise UsageError(
                    f"{effect.name}: {p.name} must lie between {p.lower:g} and {p.upper:g}",
                    value=value, unit=p.unit,
                )  # fmt: skip
            all_values |= {f"{owner}.{p.name}": value for owner in owners}
        chain = chain.with_link(link(effect, channels, owners))
    return chain, all_values


def simulate(
    experiment: ExperimentName,
    robot: Biped | Hexapod,
    plans: Plans,
    requests: Sequence[EffectRequest],
    *,
    seed: int,
    spread: Spread | None = None,
    given: Mapping[str, float] | None = None,
    motion: Mapping[str, FloatArray] | None = None,
) -> Scenario:
    """Simulate one session of an experiment.

    Parameters
    ----------
    given
        Scales, biases and offsets to use instead of drawn ones, by full parameter name.
    motion
        Columns of a recorded stand or walk (`motion_columns`) in place of the planned one.
    """
    spread = spread or Spread()
    if isinstance(robot, Hexapod):
        chain, values = mounting(robot, spread, seed)
        values = _as_given(values, given, ".offset_")
        chain, values = with_effects(chain, values, requests, robot.channels)
        return _on_hips(experiment, robot, plans, chain, values, seed)
    chain, values = ankle_offsets(robot, seed) if robot.ankles else calibration(robot, spread, seed)
    values = _as_given(values, given, ".")
    chain, values = with_effects(chain, values, requests, robot.channels)
    if experiment == "weights":
        logs = list(weights_logs(robot, plans.weights, chain, values, seed=seed).values())
        return _scenario({"weights": weights_columns(logs)}, logs[0], chain, values)
    if experiment == "placements":
        logs = [
            placements_log(robot, foot, plans.placements, chain, values, seed=seed)
            for foot in robot.feet
        ]
        return _scenario({"placements": placements_columns(logs)}, logs[0], chain, values)
    loads_at = None
    if motion is not None:
        motion_at, loads_at = recorded(robot, motion)
        duration_s = float(motion["time_s"][-1])
    elif experiment == "stand":
        motion_at, duration_s = standing_motion(robot, plans.stand, seed), plans.stand.duration_s
    else:
        motion_at, duration_s = _walk(robot, plans.walk), plans.walk.duration_s
    if robot.ankles:
        on_ankles = ankle_logs(
            Course(experiment, robot, motion_at, duration_s), chain, values,
            seed=seed, streams=plans.streams,
        )  # fmt: skip
        files = {"wrenches": wrenches_columns(on_ankles), "body": ankle_body_columns(on_ankles)}
        return _scenario(files, on_ankles.wrenches, chain, values)
    both = biped_logs(
        Course(experiment, robot, motion_at, duration_s, loads_at), chain, values,
        seed=seed, streams=plans.streams,
    )  # fmt: skip
    return biped_scenario(robot, both)


def _as_given(
    drawn: Mapping[str, float], given: Mapping[str, float] | None, kind: str
) -> dict[str, float]:
    """Drawn values with those replaced that were given (names that contain `kind`)."""
    if given is None:
        return dict(drawn)
    taken = {name: given[name] for name in drawn if kind in name and name in given}
    if not taken:
        raise UsageError(
            "the calibration holds no parameter of this robot",
            remedy=f"it should have names like {next(n for n in drawn if kind in n)}",
        )
    return {**drawn, **taken}


def _walk(robot: Biped, plan: WalkPlan) -> MotionAt:
    return lambda time_s: walking(robot, plan, time_s)


def biped_scenario(robot: Biped, both: BipedLogs) -> Scenario:
    """The files of a standing or walking biped."""
    files = {
        "cells": cells_columns(both),
        "body": body_columns(both, list(robot.feet)),
        "true_loads": loads_columns(both.cells.truth),
    }
    return _scenario(files, both.cells, both.cells.chain, both.cells.values)


def _on_hips(
    experiment: str,
    robot: Hexapod,
    plans: Plans,
    chain: Chain,
    values: Mapping[str, float],
    seed: int,
) -> Scenario:
    if experiment == "hang":
        logs = {
            leg: simulated_hang_log(robot, leg, plans.hang, chain, values, seed=seed)
            for leg in robot.legs
        }
        files = {"hang": hang_columns(logs, robot, plans.hang)}
        return _scenario(files, next(iter(logs.values())), chain, values)
    done = simulated_pose_log(robot, plans.pose, chain, values, seed=seed)
    return _scenario({"poses": poses_columns(done, list(robot.legs))}, done, chain, values)


def _scenario(
    files: Mapping[str, Columns], done: Simulated, chain: Chain, values: Mapping[str, float]
) -> Scenario:
    plain = {name: np.asarray(value).item() for name, value in values.items()}
    return Scenario(files, chain, plain, done.log, done.truth)

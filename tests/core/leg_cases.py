"""Simulated hanging legs and standing poses as cases of the diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from footcal_cli.core.chain import Chain, Link, chain_of, link
from footcal_cli.core.diagnosis.investigation import Investigation, investigate
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.experiments import hang, pose
from footcal_cli.core.hang.effect import hanging_effect
from footcal_cli.core.hang.joint import fit_hang
from footcal_cli.core.hang.runs import blocked
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    offset_values,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.noise import SimulatedNoise
from footcal_cli.core.simulation.robots import Hexapod
from footcal_cli.intake.cases.pose import pose_blocks

ROBOT = Hexapod()
LEGS = ("fl", "mr")
ROUNDS = 3
"""How often the robot is hung in its four orientations."""
FORCE_SD_N, TORQUE_SD_NM = 0.04, 0.0024
HUNG = HangPlan(
    cycles=4, cycle_s=10.0, rate_hz=2.4,
    force_noise=SimulatedNoise(white=FORCE_SD_N), torque_noise=SimulatedNoise(white=TORQUE_SD_NM),
)  # fmt: skip
STOOD = PosePlan(
    poses=60, tripods=60, friction_n=3.0, uneven=0.5, tilt_rad=0.1,
    force_noise=SimulatedNoise(white=FORCE_SD_N), torque_noise=SimulatedNoise(white=TORQUE_SD_NM),
)  # fmt: skip
FAMILIES = ("white", "ar90", "ar98", "heteroscedastic", "block_gain_offset")


def distorting(
    effect: str, owner: str, sizes: Mapping[str, float]
) -> tuple[Chain, dict[str, float]]:
    """Offsets, and one effect of one leg (or axis, or the robot); none where `effect` is empty."""
    chain = Chain((link(TABLE["offset"], ROBOT.channels),))
    values = offset_values(ROBOT)
    if effect:
        chain = chain_of([*chain.links, Link(TABLE[effect], {owner: (owner,)})])
        values |= {f"{owner}.{name}": size for name, size in sizes.items()}
    return chain, values


def hung_logs(
    seed: int, chain: Chain, values: Mapping[str, float], family: str = "white"
) -> dict[str, list[Log]]:
    """Logs per leg, one per round; every hanging a little askew and with offsets of its own."""
    rng = np.random.default_rng([77, seed])
    logs: dict[str, list[Log]] = {}
    for leg in LEGS:
        clock, parts = 0.0, []
        for turn in range(ROUNDS):
            one = simulated_hang_log(ROBOT, leg, HUNG, chain, values, seed=1000 * seed + turn).log
            one = replace(one, time_s=one.time_s + clock)
            clock = float(one.time_s[-1]) + 60.0
            warm = 22.0 + 3.0 * np.sin(one.time_s / 300.0 + turn)
            parts.append(one.with_known(temperature_degc=warm))
        logs[leg] = [_shaken(rng, part, family) for part in parts]
    return logs


def drifting(
    logs: Mapping[str, list[Log]], leg: str, axis: int, rate_n_s: float
) -> dict[str, list[Log]]:
    """The logs with an offset that drifts from the first hanging of a leg to its last one.

    Added by hand: a round that is simulated starts its clock anew.
    """
    start_s = float(logs[leg][0].time_s[0])
    moved = []
    for log in logs[leg]:
        readings = log.readings.copy()
        readings[:, axis] += rate_n_s * (log.time_s - start_s)
        moved.append(log.with_readings(readings))
    return {**logs, leg: moved}


def stepped(
    logs: Mapping[str, list[Log]], leg: str, axis: int, share: float, step_n: float
) -> dict[str, list[Log]]:
    """The logs with a step of one axis from a share of a leg's rows on, by hand like `drifting`."""
    start = int(share * sum(len(log) for log in logs[leg]))
    moved = []
    for log in logs[leg]:
        readings = log.readings.copy()
        readings[max(start, 0) :, axis] += step_n
        moved.append(log.with_readings(readings))
        start -= len(log)
    return {**logs, leg: moved}


def _shaken(rng: np.random.Generator, log: Log, family: str) -> Log:
    """A log with what does not repeat between its hangings, and the noise of a family."""
    run = log.block // HUNG.cycles
    sd = np.array([FORCE_SD_N] * 3 + [TORQUE_SD_NM] * 3)
    share = 0.5 if family == "block_gain_offset" else 0.1
    number = int(run.max()) + 1
    loose = share * sd * rng.standard_normal((number, 6))
    added = loose[run]
    if family in ("ar90", "ar98"):
        keep = 0.9 if family == "ar90" else 0.98
        slow = np.zeros((len(log), 6))
        for t in range(1, len(log)):
            slow[t] = keep * slow[t - 1] + np.sqrt(1 - keep**2) * rng.standard_normal(6)
        added = added + sd * slow
    elif family == "heteroscedastic":
        added = added + sd * np.abs(log.readings - log.readings.mean(0)) / (
            log.readings.std(0) + 1e-9
        ) * rng.standard_normal((len(log), 6))
    return log.with_readings(log.readings + added)


def hang_case(logs: Mapping[str, list[Log]], tolerance_n: float = 0.02) -> Case:
    """The case as the command makes it, from the joint fit of each leg."""
    joined, _ = blocked(logs)
    chain = Chain((link(TABLE["offset"], tuple(c for log in joined for c in log.channels)),))
    values: dict[str, float] = {}
    free: list[Parameter] = []
    for leg, own in logs.items():
        fit = fit_hang(own)
        chain = chain.with_link(Link(hanging_effect(fit.model), {leg: (leg,)}))
        values |= dict(zip(fit.estimates.names, fit.estimates.values.tolist(), strict=True))
        free += [replace(p, value=values[p.name]) for p in fit.model.parameters(0.0)]
    return Case(
        experiment=hang.EXPERIMENT, logs=joined, chain=chain, values=values,
        calibration=ParameterSet(tuple(free)), tolerance_n=tolerance_n,
        tolerance_nm=0.06 * tolerance_n, alike=False, shared_blocks=True, setting_key="hanging",
    )  # fmt: skip


def pose_case(
    seed: int, chain: Chain, values: Mapping[str, float], *, mounted: bool = True,
    family: str = "white", tolerance_n: float = 0.03, poses: int = 120,
) -> Case:  # fmt: skip
    """Poses on a robot whose offsets (and mounting, where `mounted`) are calibrated."""
    plan = replace(STOOD, poses=poses // 2, tripods=poses - poses // 2)
    log = simulated_pose_log(ROBOT, plan, chain, values, seed=seed).log
    order = np.random.default_rng([78, seed]).permutation(poses)
    log = replace(
        log, readings=log.readings[order], known={k: v[order] for k, v in log.known.items()},
        block=pose_blocks(poses),
    )  # fmt: skip
    log = log.with_readings(log.readings + _family(seed, log, family))
    names = ("offset", "mount_rotation", "mount_translation") if mounted else ("offset",)
    model = chain_of([link(TABLE[name], ROBOT.channels) for name in names])
    start = offset_values(ROBOT)
    free = tuple(replace(p, value=start.get(p.name, p.value)) for p in model.parameters())
    return Case(
        experiment=pose.EXPERIMENT, logs=(log,), chain=model, values=start,
        calibration=ParameterSet(free), tolerance_n=tolerance_n, tolerance_nm=0.1 * tolerance_n,
        alike=False,
    )  # fmt: skip


def _family(seed: int, log: Log, family: str) -> FloatArray:
    """Further noise of a pose log, shape (n, c)."""
    rng = np.random.default_rng([79, seed])
    sd = np.tile([FORCE_SD_N] * 3 + [TORQUE_SD_NM] * 3, log.readings.shape[1] // 6)
    unit = rng.standard_normal(log.readings.shape)
    if family in ("ar90", "ar98"):
        keep = 0.9 if family == "ar90" else 0.98
        for t in range(1, len(log)):
            unit[t] = keep * unit[t - 1] + np.sqrt(1 - keep**2) * unit[t]
        return np.asarray(0.5 * sd * unit)
    if family == "heteroscedastic":
        return np.asarray(sd * unit * np.abs(log.readings) / (np.abs(log.readings).mean(0) + 1e-9))
    if family == "block_gain_offset":
        return np.asarray(
            0.5 * sd * rng.standard_normal((log.block.max() + 1, unit.shape[1]))[log.block]
        )
    return np.zeros_like(unit)


def investigated(case: Case, *without: str) -> Investigation:
    """Diagnosed with the whole table but for cells' words."""
    cells = {"sign_flip", "dead_zone", "hinge", "saturation", "nonlinearity_cubic", "channel_swap"}
    clockless = {"offset_drift", "offset_change"} if case.experiment.name == "pose" else set()
    hidden = cells | clockless | set(without)
    table = {name: effect for name, effect in TABLE.items() if name not in hidden}
    return investigate(case, table, describe, Rules(), 0)

"""The commands' own fits, from arrays, on logs with a known truth: errors must match their sd."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import pytest

from footcal_cli.core import calibrate
from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects.calibration import OFFSET
from footcal_cli.core.effects.foot import CELL_POSITION
from footcal_cli.core.effects.six_axis import MOUNT_ROTATION
from footcal_cli.core.effects.six_axis_beliefs import HANG_TILT
from footcal_cli.core.hang.joint import HangFit
from footcal_cli.core.log import Log
from footcal_cli.core.online.noise import WalkNoise
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import (
    PlacementsPlan,
    WeightsPlan,
    placements_log,
    weights_logs,
)
from footcal_cli.core.simulation.biped_logs import (
    BipedLogs,
    Course,
    MotionAt,
    StandPlan,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.plans import Spread
from footcal_cli.core.simulation.robots import Biped, Hexapod
from footcal_cli.core.simulation.scenario import calibration, mounting

BIPED, HEXAPOD, SPREAD = Biped(), Hexapod(), Spread()
WEIGHED = WeightsPlan(sessions=12, hold_s=2.0)
"""Gain and offset differ from session to session, which is what the sd is made of."""


def in_sd(found: calibrate.Calibration[Any], truth: Mapping[str, float]) -> FloatArray:
    """Error of every parameter that the truth has, in its sd."""
    known = [i for i, name in enumerate(found.estimates.names) if name in truth]
    true = np.array([truth[found.estimates.names[i]] for i in known])
    return np.asarray((found.estimates.values[known] - true) / found.sd[known])


def weighed(seed: int) -> FloatArray:
    chain, truth = calibration(BIPED, SPREAD, seed)
    log = weights_logs(BIPED, WEIGHED, chain, truth, seed=seed)["left_fl"].log
    load_n, counts = log.known["load_n"][:, 0], log.readings[:, 0]
    found = calibrate.weights("left_fl", load_n, counts, time_s=log.time_s, session=log.block)
    return in_sd(found, truth)


def placed(seed: int) -> FloatArray:
    """Cells of a foot that stand some millimetres from where they are believed."""
    rng = np.random.default_rng(seed)
    cells = tuple(f"left_{cell}" for cell in BIPED.feet["left"])
    truth = {f"{c}.cell_correction_{axis}": 0.002 * rng.normal() for c in cells for axis in "xy"}
    chain, plan = chain_of([link(CELL_POSITION, cells)]), PlacementsPlan(repeats=2)
    log = placements_log(BIPED, "left", plan, chain, truth, seed=seed, to_counts=False).log
    holes, load_n = log.known["hole_m"], log.known["load_n"]
    found = calibrate.placements(cells, BIPED.cells_m("left"), log.readings, holes, load_n)
    return in_sd(found, truth)


def hung(seed: int, legs: Iterable[str]) -> list[calibrate.Calibration[HangFit]]:
    """Legs believed 2 % too heavy, hanging a little askew on transducers mounted askew."""
    _, truth = mounting(HEXAPOD, SPREAD, seed)
    found = []
    for leg in legs:
        channels = [c for c in HEXAPOD.channels if c.startswith(f"{leg}.")]
        chain = chain_of(link(effect, channels) for effect in (HANG_TILT, MOUNT_ROTATION, OFFSET))
        log = simulated_hang_log(HEXAPOD, leg, HangPlan(), chain, truth, seed=seed).log
        believed_n = 1.02 * HEXAPOD.legs[leg].weight_n
        phase, down = log.known["phase_rad"], log.known["gravity_dir"]
        found.append(calibrate.hang(leg, log.time_s, phase, log.readings, down, believed_n))
    return found


def hanging(seed: int) -> FloatArray:
    _, truth = mounting(HEXAPOD, SPREAD, seed)
    offsets = {name: value for name, value in truth.items() if ".offset_" in name}
    (found,) = hung(seed, ["ml"])
    return in_sd(found, {**offsets, "ml.weight": HEXAPOD.legs["ml"].weight_n})


def posed(seed: int) -> FloatArray:
    chain, truth = mounting(HEXAPOD, SPREAD, seed)
    log = simulated_pose_log(HEXAPOD, PosePlan(), chain, truth, seed=seed).log
    design = calibrate.Geometry(
        tuple(HEXAPOD.legs), HEXAPOD.hip_rot_bt, HEXAPOD.hip_pos_b_m,
        np.array(HEXAPOD.chassis_com_b_m),
    )  # fmt: skip
    found = calibrate.poses(
        design, hung(seed, HEXAPOD.legs), log.readings.reshape(len(log), -1, 6),
        log.known["phase_rad"], log.known["rot_wb"], HEXAPOD.weight_n,
    )  # fmt: skip
    return in_sd(found, truth)


def wandered(log: Log, truth: Mapping[str, float], seed: int) -> Log:
    """Counts of cells whose gains and biases drift as a walk's estimator expects, to the truth."""
    rng, noise = np.random.default_rng([seed, 1]), WalkNoise().for_weight(BIPED.weight_n)
    root_s = np.sqrt(np.diff(log.time_s, prepend=log.time_s[0]))[:, None]
    steps = root_s * rng.standard_normal((2, *log.readings.shape))
    gain, bias_n = np.cumsum(steps, axis=1) * np.reshape(
        [noise.gain_walk, noise.bias_walk_n], (2, 1, 1)
    )
    scale, bias = (
        np.array([truth[f"{c}.{name}"] for c in log.channels]) for name in ("scale", "bias")
    )
    force = scale * log.readings + bias - (bias_n - bias_n[-1])
    return log.with_readings(np.rint((force - bias) / (scale * (1.0 + gain - gain[-1]))))


def moving(kind: str, seed: int, motion: MotionAt, seconds: float) -> FloatArray:
    chain, truth = calibration(BIPED, SPREAD, seed)
    logs: BipedLogs = biped_logs(Course(kind, BIPED, motion, seconds), chain, truth, seed=seed)
    cells, body = logs.cells.log, logs.body.known
    if kind == "walk":
        cells = wandered(cells, truth, seed)
    scale = np.full(len(BIPED.channels), BIPED.scale_n_per_count)
    sheet = calibrate.nameplate(
        BIPED.channels, scale, -scale * BIPED.zero_counts, SPREAD.scale, SPREAD.bias_n
    )
    fit: Callable[..., calibrate.Calibration[Any]] = (
        calibrate.stand if kind == "stand" else calibrate.walk
    )
    found = fit(
        calibrate.SensorStream(cells.time_s, cells.readings, BIPED.channels),
        calibrate.BodyStream(
            logs.body.time_s, body["com_m"], body["com_acc_mps2"], body["angmom_rate_nm"],
            logs.foot_m, logs.foot_yaw_rad,
        ),
        sheet, [BIPED.cells_m(foot) for foot in BIPED.feet], BIPED.mass_kg,
    )  # fmt: skip
    return in_sd(found, truth)


def stood(seed: int) -> FloatArray:
    plan = StandPlan()
    return moving("stand", seed, standing_motion(BIPED, plan, seed), plan.duration_s)


def walked(seed: int) -> FloatArray:
    plan = WalkPlan()
    return moving("walk", seed, lambda t: walking(BIPED, plan, t), plan.duration_s)


@pytest.mark.parametrize(
    ("fit", "seeds"),
    [
        (hanging, 15), (stood, 20), (placed, 20),
        pytest.param(posed, 10, marks=pytest.mark.slow),
        pytest.param(weighed, 40, marks=pytest.mark.slow),
        # errors of one walk are alike: RMS of a walk 0.3 to 1.5, of sixteen walks 0.8 to 1.0
        pytest.param(walked, 40, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_errors_match_their_sd(fit: Callable[[int], FloatArray], seeds: int) -> None:
    rms = float(np.sqrt(np.mean(np.array([fit(seed) for seed in range(seeds)]) ** 2)))
    assert 0.85 <= rms <= 1.15

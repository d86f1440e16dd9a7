"""Six experiments as `diagnose` takes them, simulated with the noise and options it has by default.

Each one is recorded with or without one hidden effect, and with or without noise: what the effect
does to the residual is the difference of two recordings without any.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from footcal_cli.core.chain import Chain, Link, chain_of, link
from footcal_cli.core.contact import airborne
from footcal_cli.core.diagnosis.blocks import cut_balanced, piece_means
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.experiments import hang, placements, pose, stand, walk, weights
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.hang.runs import blocked
from footcal_cli.core.inference.case import Case
from footcal_cli.core.inference.tracking import gain_and_bias
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, ParameterSet
from footcal_cli.core.simulation.bench_logs import (
    PlacementsPlan,
    WeightsPlan,
    placements_log,
    weights_logs,
)
from footcal_cli.core.simulation.biped_logs import (
    Course,
    MotionAt,
    StandPlan,
    Streams,
    biped_logs,
    standing_motion,
)
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    offset_values,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.measure import counted
from footcal_cli.core.simulation.noise import QUIET
from footcal_cli.core.simulation.plans import Spread
from footcal_cli.core.simulation.robots import Hexapod
from footcal_cli.core.simulation.scenario import hang_tilts, mounting
from footcal_cli.intake.cases.cells import unseen_walking
from footcal_cli.intake.cases.hang import unseen_hanging
from footcal_cli.intake.cases.pose import pose_blocks, with_known_offsets
from footcal_cli.intake.cases.shared import needs_time, of_cells
from tests.core.leg_cases import LEGS, hang_case
from tests.core.test_diagnosis_bridge import ROBOT, affine, calibrated

HEXAPOD = Hexapod()
MM = 1e-3
"""Error of a centre of pressure that matters, m; forces: what each command takes by default."""
WEIGHTS = WeightsPlan(sessions=7)
"""As many sessions as a cause in one cell needs to reach the level of a family of tests."""
PLACED = PlacementsPlan(repeats=5)
ROUNDS = 4
"""How often every weight is put into every hole: what differs between rounds must be known."""
STOOD = StandPlan(stances=24, one_foot=12)
WALKED = WalkPlan(duration_s=60.0)
HUNG = HangPlan(cycles=4, cycle_s=10.0, rate_hz=2.4)
HANGINGS = 3
"""How often the robot is hung in its four orientations."""
HUNG_OFFSETS = np.diag([0.02] * 3 + [0.002] * 3) ** 2
"""Covariance with which hanging knows the offsets of a leg, N² and N² m²."""
POSED = PosePlan(poses=120, tripods=60, friction_n=3.0, uneven=0.5, tilt_rad=0.1)
DRIFT_OF_GAIN, DRIFT_OF_BIAS_N = 2e-4, 0.01
"""Random walk of the cells within the root of a second of walking."""


@dataclass(frozen=True)
class Hidden:
    """An effect in a recording.

    Parameters
    ----------
    effect, owners
        As in a chain's link.
    parameter
        The size that is not neutral.
    values
        Size and shapes by full parameter name.
    """

    effect: Effect
    owners: Mapping[str, tuple[str, ...]]
    parameter: str
    values: Mapping[str, float]

    @property
    def size(self) -> float:
        """Of every owner."""
        return self.values[f"{next(iter(self.owners))}.{self.parameter}"]

    def resized(self, size: float) -> Hidden:
        """The same effect, larger or smaller."""
        sizes = {f"{owner}.{self.parameter}": size for owner in self.owners}
        return replace(self, values={**self.values, **sizes})


Recorded = Callable[[Hidden | None, int, bool], tuple[Log, ...]]
"""(hidden effect, seed, with noise) -> logs."""


@dataclass(frozen=True)
class World:
    """An experiment that can be recorded and diagnosed.

    Parameters
    ----------
    record
        The logs.
    case
        (logs, seed) -> the case that the command makes of them.
    experiment, channels
        What is balanced, and what is read.
    untested
        Effects that the command does not try, with its reason.
    """

    record: Recorded
    case: Callable[[tuple[Log, ...], int], Case]
    experiment: Experiment
    channels: tuple[str, ...]
    untested: Mapping[str, str]


def _with(
    chain: Chain, values: Mapping[str, float], hidden: Hidden | None
) -> tuple[Chain, dict[str, float]]:
    if hidden is None:
        return chain, dict(values)
    extended = chain.with_link(Link(hidden.effect, dict(hidden.owners)))
    return extended, {**values, **hidden.values}


def _cells() -> Chain:
    return Chain((link(TABLE["scale_bias"], ROBOT.channels),))


def _affine_case(experiment: Experiment, logs: tuple[Log, ...], seed: int) -> Case:
    """The calibration is the true one: it is refitted, as that of a log without an effect is."""
    values = calibrated(seed)
    return Case(
        experiment, logs, _cells(), values, affine(values),
        tolerance_n=0.001 * ROBOT.weight_n, tolerance_nm=MM * ROBOT.weight_n, alike=False,
        groups=dict.fromkeys(ROBOT.channels, "swing"),
    )  # fmt: skip


def record_weights(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """A log per cell, as the command reads them."""
    plan = WEIGHTS if noisy else replace(WEIGHTS, noise=QUIET)
    done = weights_logs(ROBOT, plan, *_with(_cells(), calibrated(seed), hidden), seed=seed)
    return tuple(each.log for each in done.values())


def weights_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are sessions of a cell."""
    largest = max(WEIGHTS.loads_n)
    return replace(
        _affine_case(weights.EXPERIMENT, logs, seed), alike=True, tolerance_n=0.002 * largest,
        tolerance_nm=MM * largest, groups=dict.fromkeys(ROBOT.channels, "force"),
    )  # fmt: skip


def record_placements(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """A log per foot, a row per placement, in another order in every round."""
    plan = PLACED if noisy else replace(PLACED, noise=QUIET)
    nothing = Chain(()), dict[str, float]()
    believed = hidden is not None and Trait.BELIEF in hidden.effect.traits
    # the bench's simulator numbers placements, not holes: a wrong hole is a belief about the log
    wrong = hidden is not None and hidden.effect.name == "wrong_hole"
    on_bench = _with(*nothing, hidden if believed and not wrong else None)
    in_cells = _with(_cells(), calibrated(seed), None if believed else hidden)
    logs = []
    for foot in ROBOT.feet:
        parts, clock = [], 0.0
        for number in range(ROUNDS):
            one = placements_log(
                ROBOT, foot, plan, *on_bench, seed=100 * seed + number, to_counts=False
            ).log
            rng = np.random.default_rng([9, seed, number])
            order = rng.permutation(int(one.block.max()) + 1)
            rows = np.concatenate([np.flatnonzero(one.block == placement) for placement in order])
            known = {name: array[rows] for name, array in one.known.items()}
            known["round"] = np.full(rows.size, float(number))
            # a room that warms and cools, out of step with the holes
            known["temperature_degc"] = 25.0 + 4.0 * np.sin(
                0.9 * number + 0.11 * np.arange(rows.size)
            )
            block = np.repeat(np.arange(order.size), plan.repeats) + number * order.size
            parts.append(
                replace(one, time_s=one.time_s + clock, readings=one.readings[rows], known=known,
                        block=block)
            )  # fmt: skip
            clock = float(parts[-1].time_s[-1]) + 60.0
        log, _ = in_cells[0].apply(_joined(parts), in_cells[1])
        log = _placement_means(counted(log, ROBOT))
        number_of = np.unique(log.known["hole_m"].round(6), axis=0, return_inverse=True)[1]
        log = log.with_known(hole=np.asarray(number_of).ravel().astype(float))
        if wrong and hidden is not None:
            log, _ = Chain((Link(hidden.effect, dict(hidden.owners)),)).apply(log, hidden.values)
        logs.append(log)
    return tuple(logs)


def _placement_means(log: Log) -> Log:
    """One row per placement."""

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([values[log.block == b].mean(axis=0) for b in blocks])

    blocks = np.unique(log.block)
    known = {name: mean(array) for name, array in log.known.items()}
    return replace(
        log, time_s=mean(log.time_s), readings=mean(log.readings), known=known, block=blocks
    )


def _joined(parts: list[Log]) -> Log:
    """Logs of the same channels, one after the other."""
    return replace(
        parts[0],
        time_s=np.concatenate([part.time_s for part in parts]),
        readings=np.concatenate([part.readings for part in parts]),
        known={k: np.concatenate([part.known[k] for part in parts]) for k in parts[0].known},
        block=np.concatenate([part.block for part in parts]),
    )


def placements_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are placements."""
    largest = max(PLACED.loads_n)
    outputs = ("fz", "moment_x", "moment_y")
    return replace(
        _affine_case(placements.EXPERIMENT, logs, seed), tolerance_n=0.005 * largest,
        tolerance_nm=MM * largest, setting_key="round",
        groups={f"{foot}.{o}": o for foot in ROBOT.feet for o in outputs},
    )  # fmt: skip


def _balanced(
    kind: str, motion: MotionAt, seconds: float, hidden: Hidden | None, seed: int, noisy: bool
) -> Log:
    """Cells and body of a moving robot at the cells' stamps."""
    streams = Streams() if noisy else Streams(cell_noise=QUIET)
    log = biped_logs(
        Course(kind, ROBOT, motion, seconds), *_with(_cells(), calibrated(seed), hidden), seed=seed,
        streams=streams,
    ).cells.log  # fmt: skip
    log = log.with_known(airborne=airborne(log.known["contact"]))
    if not noisy:
        return log
    rng = np.random.default_rng([5, seed])
    low_pass = butter(2, 10.0, fs=streams.cell_rate_hz, output="sos")
    known = dict(log.known)
    for name, sd in (
        ("com_m", streams.com_noise_m),
        ("com_acc_mps2", streams.acc_noise_mps2),
        ("angmom_rate_nm", streams.angmom_noise_nm),
    ):
        # cells and body are merged through one low-pass
        noise = sd * rng.standard_normal(known[name].shape)
        known[name] = known[name] + sosfiltfilt(low_pass, noise, axis=0)
    return replace(log, known=known)


def record_stand(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """A few rows and a block per stance, on both feet and on one."""
    motion = standing_motion(ROBOT, STOOD, seed)
    return (piece_means(_balanced("stand", motion, STOOD.duration_s, hidden, seed, noisy)),)


def stand_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are stances."""
    return replace(_affine_case(stand.EXPERIMENT, logs, seed), one_recording=True, pieces=True)


def record_walk(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """A walk; with noise its cells drift too."""
    log = _balanced("walk", lambda t: walking(ROBOT, WALKED, t), WALKED.duration_s, hidden, seed,
                    noisy)  # fmt: skip
    if noisy:
        values, rng = calibrated(seed), np.random.default_rng([6, seed])
        steps = np.sqrt(np.diff(log.time_s, prepend=log.time_s[0]))[:, None]
        wander = np.cumsum(steps * rng.standard_normal((2, *log.readings.shape)), axis=1)
        scale = np.array([values[f"{c}.scale"] for c in ROBOT.channels])
        zero = np.array([values[f"{c}.bias"] for c in ROBOT.channels])
        force = (log.readings * scale + zero) * (1.0 + DRIFT_OF_GAIN * wander[0])
        log = log.with_readings((force + DRIFT_OF_BIAS_N * wander[1] - zero) / scale)
    return (cut_balanced(log),)


def walk_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are gait cycles; the calibration is tracked."""
    case = _affine_case(walk.EXPERIMENT, logs, seed)
    return replace(
        case, drifts=True, stride=4, one_recording=True, demand_noisy=True,
        directions=gain_and_bias(ROBOT.channels, case.values),
    )  # fmt: skip


def record_hang(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """A log per leg; the robot is hung several times, each time a little askew."""
    plan = HUNG if noisy else replace(HUNG, force_noise=QUIET, torque_noise=QUIET)
    rounds: dict[str, list[Log]] = {leg: [] for leg in LEGS}
    for leg, parts in rounds.items():
        channels = tuple(c for c in HEXAPOD.channels if c.startswith(f"{leg}."))
        clock = 0.0
        for turn in range(HANGINGS):
            askew = hang_tilts(leg, HEXAPOD.legs[leg], Spread().hang_tilt_rad, 100 * seed + turn)
            chain = Chain((link(TABLE["hang_tilt"], channels),))
            one = simulated_hang_log(HEXAPOD, leg, plan, chain, askew, seed=100 * seed + turn).log
            one = replace(one, time_s=one.time_s + clock)
            clock = float(one.time_s[-1]) + 60.0
            warm = 22.0 + 3.0 * np.sin(one.time_s / 300.0 + turn)
            parts.append(one.with_known(temperature_degc=warm))
    chain = Chain((link(TABLE["offset"], HANGING),))
    distort, values = _with(chain, offset_values(HEXAPOD), hidden)
    # sensors distort on one clock that goes on from hanging to hanging
    return tuple(distort.apply(log, values)[0] for log in blocked(rounds)[0])


def hung_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are turns; the calibration is the joint fit of each leg to these very logs."""
    del seed
    weight_n = float(np.mean([HEXAPOD.legs[leg].weight_n for leg in LEGS]))
    case = hang_case(dict(zip(LEGS, ([log] for log in logs), strict=True)))
    return replace(case, tolerance_n=0.005 * weight_n, tolerance_nm=MM * weight_n)


def _hips(seed: int) -> tuple[Chain, dict[str, float]]:
    """Offsets and mountings as `pose-calib` leaves them: true, and refitted."""
    _, values = mounting(HEXAPOD, Spread(), seed)
    chain = chain_of([link(TABLE[name], HEXAPOD.channels) for name in pose.EXPERIMENT.calibration])
    names = set(chain.parameters().names)
    return chain, {name: float(value) for name, value in values.items() if name in names}


def record_pose(hidden: Hidden | None, seed: int, noisy: bool) -> tuple[Log, ...]:
    """Poses on six legs and on three, in any order."""
    plan = POSED if noisy else replace(POSED, force_noise=QUIET, torque_noise=QUIET)
    log = simulated_pose_log(HEXAPOD, plan, *_with(*_hips(seed), hidden), seed=seed).log
    poses = len(log)
    order = np.random.default_rng([78, seed]).permutation(poses)
    return (
        replace(
            log, readings=log.readings[order], known={k: v[order] for k, v in log.known.items()},
            block=pose_blocks(poses),
        ),
    )  # fmt: skip


def pose_case(logs: tuple[Log, ...], seed: int) -> Case:
    """Blocks are some poses in a row."""
    chain, values = _hips(seed)
    free = tuple(replace(p, value=values[p.name]) for p in chain.parameters())
    case = Case(
        pose.EXPERIMENT, logs, chain, values, ParameterSet(free),
        tolerance_n=0.002 * HEXAPOD.weight_n, tolerance_nm=MM * HEXAPOD.weight_n, alike=False,
    )  # fmt: skip
    return with_known_offsets(case, dict.fromkeys(HEXAPOD.legs, HUNG_OFFSETS))


HANGING = tuple(c for c in HEXAPOD.channels if c.split(".")[0] in LEGS)
WORLDS = {
    "weights": World(record_weights, weights_case, weights.EXPERIMENT, ROBOT.channels, {}),
    "placements": World(
        record_placements, placements_case, placements.EXPERIMENT, ROBOT.channels, {}
    ),
    "stand": World(record_stand, stand_case, stand.EXPERIMENT, ROBOT.channels, {}),
    "walk": World(record_walk, walk_case, walk.EXPERIMENT, ROBOT.channels, unseen_walking()),
    "hang": World(record_hang, hung_case, hang.EXPERIMENT, HANGING, unseen_hanging()),
    "pose": World(
        record_pose,
        pose_case,
        pose.EXPERIMENT,
        HEXAPOD.channels,
        of_cells(pose.EXPERIMENT)
        | needs_time(pose.EXPERIMENT, "poses have no time stamps")
        | {"body_tilt": "no pose distinguishes it from a rotation of all mountings"},
    ),
}

"""Simulate an effect, fit it through the experiment's balance: the error must match its sd."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from zlib import crc32

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, Link, chain_of, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Scope, can_carry
from footcal_cli.core.experiments import hang, placements, pose, stand, walk, weights
from footcal_cli.core.inference.fit import fit_map, numeric_jacobian
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Parameter, ParameterSet
from footcal_cli.core.simulation.bench_logs import (
    PlacementsPlan,
    WeightsPlan,
    placements_log,
    weights_logs,
)
from footcal_cli.core.simulation.biped_logs import (
    Course,
    StandPlan,
    Streams,
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
from footcal_cli.core.simulation.measure import Simulated
from footcal_cli.core.simulation.noise import SimulatedNoise
from footcal_cli.core.simulation.robots import Biped, Hexapod
from tests.contract.whitening import white_errors, whitening
from tests.core.ankle_simulation import Ankles, humanoid, six_axis_feet_log

BIPED, HEXAPOD, HUMANOID = Biped(), Hexapod(), humanoid()
FORCE_SD_N, TORQUE_SD_NM = 0.04, 0.004
FORCE, TORQUE = SimulatedNoise(white=FORCE_SD_N), SimulatedNoise(white=TORQUE_SD_NM)
SEEDS = 80
"""Of the hundred and fifty cases chance throws one out of 0.85 to 1.15 in forty runs."""
VISIBLE = 5.0
"""Signature per prior sd, in units of noise, from which on a log says something of a parameter."""
SHAPES = {
    "saturation_limit": 4.0, "hinge_load": 4.5, "dead_zone_width": 2.5, "label": 5.0,
    "hole": 3.0, "unit_block": 1.0,
    "bypass_load": 10.0, "jump_time": 3.0, "change_time": 4.0, "slip_time": 3.0,
    "creep_time": 10.0, "creep_slow_time": 30.0, "stuck_time": 5.0,
}  # fmt: skip
"""Shapes at which an effect shows on these short logs."""


FEET = "-on-six-axis"
"""Standing and walking on transducers are experiments of their own here."""
EXPERIMENTS = {
    "weights": weights.EXPERIMENT,
    "placements": placements.EXPERIMENT,
    "stand": stand.EXPERIMENT,
    "walk": walk.EXPERIMENT,
    "hang": hang.EXPERIMENT,
    "pose": pose.EXPERIMENT,
    f"stand{FEET}": stand.ON_SIX_AXIS,
    f"walk{FEET}": walk.ON_SIX_AXIS,
}
RESIZED = {
    "bias_drift": 20.0, "offset_drift": 100.0, "clock_drift": 20.0, "temperature": 5.0,
    "creep_slow": 4.0, "cubic": 5.0,
    "hole_correction": 0.3,
}  # fmt: skip
"""How many times larger than in practice an effect must be to show within seconds."""
OF_HEAVY_LOADS = {"quadratic": 0.02, "offset_drift": 2000.0}
"""The same for transducers that carry a hundred times what those cells do."""
QUIETER = {"sensor_lag": 0.1, "axis_flip": 0.1, "scale_matrix": 0.1, "dead_zone": 0.1}
"""Share of the noise left where removing an effect amplifies noise, a larger gain all of it: the
residual does not weigh that (its determinant is missing), so that noise biases the estimate by a
part of its sd."""
Simulator = Callable[[Chain, dict[str, float], int], Simulated]


def simulate_weights(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = WeightsPlan(
        loads_n=(0.0, 2.0, 5.0, 10.0), hold_s=8.0, sample_s=2.0, sessions=2, pause_s=10.0,
        warming_degc_per_s=0.01, noise=FORCE, pieces=(0, 1, 2, 3),
    )  # fmt: skip
    robot = Biped(feet={"left": BIPED.feet["left"]})
    logs = weights_logs(robot, plan, chain, values, seed=seed, together=True, to_counts=False)
    return logs["all"]


def simulate_placements(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = PlacementsPlan(loads_n=(5.0, 20.0), repeats=2, noise=FORCE, warming_degc_per_s=0.5)
    return placements_log(BIPED, "left", plan, chain, values, seed=seed, to_counts=False)


def simulate_stand(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = StandPlan(stances=8, stance_s=2.0, sway_m=0.0)
    streams = Streams(cell_rate_hz=10.0, cell_noise=FORCE, body_rate_hz=1.0)
    return biped_logs(
        Course("stand", BIPED, standing_motion(BIPED, plan, 3), plan.duration_s), chain, values,
        seed=seed, streams=streams, to_counts=False,
    ).cells  # fmt: skip


def simulate_walk(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = WalkPlan(duration_s=6.0, speed_mps=0.1, stand_s=0.6, turn_radps=0.1)
    streams = Streams(cell_rate_hz=60.0, cell_noise=FORCE, body_rate_hz=1.0)
    return biped_logs(
        Course("walk", BIPED, lambda t: walking(BIPED, plan, t), plan.duration_s), chain, values,
        seed=seed, streams=streams, to_counts=False,
    ).cells  # fmt: skip


def simulate_hang(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = HangPlan(cycles=1, cycle_s=10.0, rate_hz=6.0, force_noise=FORCE, torque_noise=TORQUE)
    return simulated_hang_log(HEXAPOD, "ml", plan, chain, values, seed=seed)


def simulate_pose(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = PosePlan(poses=30, tripods=6, force_noise=FORCE, torque_noise=TORQUE)
    return simulated_pose_log(HEXAPOD, plan, chain, values, seed=seed)


HEAVIER = 10.0
"""Noise of transducers that carry a person's weight over that of cells under a small robot."""
ANKLES = Ankles(
    rate_hz=60.0, force_noise=FORCE.scaled(HEAVIER), torque_noise=TORQUE.scaled(HEAVIER),
    com_noise_m=0.0, acc_noise_mps2=0.0, angmom_noise_nm=0.0, warming_degc_per_s=0.5,
)  # fmt: skip


def simulate_stand_on_ankles(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = StandPlan(stances=4, one_foot=4, stance_s=1.0, sway_m=0.0)
    motion = standing_motion(HUMANOID, plan, 3)
    return six_axis_feet_log(
        "stand", HUMANOID, motion, plan.duration_s, chain, values, seed=seed, ankles=ANKLES
    )


def simulate_walk_on_ankles(chain: Chain, values: dict[str, float], seed: int) -> Simulated:
    plan = WalkPlan(duration_s=8.0, speed_mps=0.15, stand_s=0.6, turn_radps=0.1, bob_m=0.01)
    return six_axis_feet_log(
        "walk", HUMANOID, lambda t: walking(HUMANOID, plan, t), plan.duration_s, chain, values,
        seed=seed, ankles=ANKLES,
    )  # fmt: skip


@dataclass(frozen=True)
class Bench:
    """An experiment, how its logs are simulated, and who may carry an effect in this test."""

    simulate: Simulator
    owners: dict[Scope, tuple[str, ...]]


LEFT = tuple(c for c in BIPED.channels if c.startswith("left"))
BENCHES = {
    "weights": Bench(simulate_weights, {Scope.CHANNEL: LEFT}),
    "placements": Bench(simulate_placements, {Scope.CHANNEL: LEFT, Scope.FOOT: ("left",)}),
    "stand": Bench(simulate_stand, {Scope.CHANNEL: LEFT, Scope.FOOT: ("left", "right")}),
    "walk": Bench(simulate_walk, {Scope.CHANNEL: LEFT, Scope.FOOT: ("left", "right")}),
    "hang": Bench(simulate_hang, {Scope.CHANNEL: ("ml.fx", "ml.fz", "ml.ty"), Scope.LEG: ("ml",)}),
    "pose": Bench(simulate_pose, {Scope.CHANNEL: ("fl.fz", "mr.fz"), Scope.LEG: ("hr",)}),
    f"stand{FEET}": Bench(
        simulate_stand_on_ankles, {Scope.CHANNEL: ("left.fz", "right.fz"), Scope.LEG: ("left",)}
    ),
    f"walk{FEET}": Bench(
        simulate_walk_on_ankles, {Scope.CHANNEL: ("left.fz", "right.fz"), Scope.LEG: ("left",)}
    ),
}


@cache
def clean(experiment: str) -> Log:
    return BENCHES[experiment].simulate(Chain(()), {}, 0).truth


def whitener_of(experiment: str, log: Log) -> FloatArray:
    sd = np.array([TORQUE_SD_NM if ".t" in channel else FORCE_SD_N for channel in log.channels])
    factor = HEAVIER if FEET in experiment else 1.0
    return whitening(EXPERIMENTS[experiment], log, factor * sd)


def residual(
    experiment: str, chain: Chain, log: Log, values: dict[str, float], white: FloatArray
) -> FloatArray:
    """The residual of the contract, with the correlations between the outputs taken out."""
    undistorted, _ = chain.remove(log, values)
    return white_errors(EXPERIMENTS[experiment].balance(undistorted), white)


def case_link(effect: Effect, experiment: str) -> Link:
    log = clean(experiment)
    owners = {Scope.ROBOT: ("robot",), **BENCHES[experiment].owners}[effect.scope]
    return link(effect, log.channels, owners)


def in_its_log(parameters: ParameterSet, experiment: str) -> ParameterSet:
    """Shapes and prior sds with which an effect shows on these short logs."""
    resized = RESIZED | (OF_HEAVY_LOADS if FEET in experiment else {})

    def fitted(p: Parameter) -> Parameter:
        name = p.name.rsplit(".", 1)[1]
        if not p.free:
            return replace(p, value=SHAPES.get(name, p.value))
        factors = [factor for start, factor in resized.items() if name.startswith(start)]
        return replace(p, sd=p.sd * factors[0] if factors else p.sd)

    return ParameterSet(tuple(fitted(p) for p in parameters))


def signatures(chain: Chain, experiment: str, parameters: ParameterSet, step: float) -> FloatArray:
    """Change of the residual per prior sd of each parameter, at neutral, (m, p)."""
    log = clean(experiment)
    white = whitener_of(experiment, log)

    def error(theta: FloatArray) -> FloatArray:
        values = dict(zip(parameters.names, theta, strict=True))
        return residual(experiment, chain, log, values, white)

    sizes = np.array([p.step for p in parameters])
    steps = np.where(parameters.free, step * sizes, 1e-12)
    return numeric_jacobian(error, parameters.values, steps) * np.where(parameters.free, sizes, 0)


def visible(chain: Chain, experiment: str) -> ParameterSet:
    """The parameters with those held at neutral that this log says next to nothing about."""
    parameters = in_its_log(chain.parameters(), experiment)
    information = np.sum(signatures(chain, experiment, parameters, 1e-3) ** 2, axis=0)
    return ParameterSet(
        tuple(
            replace(p, free=bool(p.free and seen > VISIBLE**2))
            for p, seen in zip(parameters, information, strict=True)
        )
    )


def drawn(parameters: ParameterSet, rng: np.random.Generator) -> dict[str, float]:
    """True values: free ones from their prior (away from a one-sided bound)."""
    values = {p.name: p.value for p in parameters}
    for p in parameters:
        if p.free and p.lower == p.value:
            values[p.name] += p.sd * rng.uniform(0.5, 1.0)
        elif p.free:
            values[p.name] += p.sd * float(np.clip(rng.standard_normal(), -2.5, 2.5))
    return values


OF_SMALL_CELLS = frozenset(
    {"nonlinearity_cubic", "dead_zone", "hinge", "sign_flip", "channel_swap"}
)
"""Their sizes and shapes are those of cells of some newtons; ankles carry hundreds."""
TRIED = [
    (effect, experiment)
    for effect in TABLE.values()
    if effect.invertible
    for experiment in EXPERIMENTS
    if experiment.removesuffix(FEET) in effect.experiments
    and can_carry(clean(experiment).channels, effect)
    and not (FEET in experiment and effect.name in OF_SMALL_CELLS)
]
CASES = [pytest.param(*case, id=f"{case[0].name}-{case[1]}") for case in TRIED]


def pulls(effect: Effect, experiment: str, seeds: int) -> FloatArray:
    """Errors in units of their sd over many seeds: ``L⁻¹ (estimate − truth)``, covariance L Lᵀ."""
    chain = chain_of([case_link(effect, experiment)])
    parameters = visible(chain, experiment)
    assert parameters.free.any(), "the experiment cannot see the effect"
    factor = QUIETER.get(effect.name, 1.0)
    found = []
    # of its own name, so that another effect in the table draws nothing anew
    first = 1000 * (crc32(effect.name.encode()) % 1000)
    for seed in range(first, first + max(seeds, -(-seeds * 4 // int(parameters.free.sum())))):
        truth = drawn(parameters, np.random.default_rng(seed))
        done = quieter(BENCHES[experiment].simulate(chain, truth, seed), truth, factor)
        white = whitener_of(experiment, done.truth) / factor

        def error(theta: FloatArray, log: Log = done.log, white: FloatArray = white) -> FloatArray:
            values = dict(zip(parameters.names, theta, strict=True))
            return residual(experiment, chain, log, values, white)

        fit = fit_map(error, parameters)
        true = np.array([truth[name] for name in parameters.names])
        free = np.flatnonzero(parameters.free)
        root = np.linalg.cholesky(fit.estimates.covariance[np.ix_(free, free)])
        found.append(np.linalg.solve(root, (fit.estimates.values - true)[free]))
    return np.concatenate(found)


def quieter(done: Simulated, values: dict[str, float], factor: float) -> Simulated:
    """The same log with a share of its noise."""
    if factor == 1.0:
        return done
    noisy, _ = done.chain.remove(done.log, values)
    calm = done.truth.readings + factor * (noisy.readings - done.truth.readings)
    shown, _ = done.chain.apply(done.truth.with_readings(calm), values)
    return replace(done, log=shown)


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "experiment"), CASES)
def test_error_matches_sd_over_eighty_seeds(effect: Effect, experiment: str) -> None:
    assert 0.85 <= rms(pulls(effect, experiment, SEEDS)) <= 1.15


@pytest.mark.parametrize(
    "experiment",
    [pytest.param(e, marks=[pytest.mark.slow] if FEET in e else []) for e in EXPERIMENTS],
)
def test_error_matches_sd(experiment: str) -> None:
    """A few seeds per effect: none may be far off, and together they must match."""
    seen = [effect for effect, where in TRIED if where == experiment]
    found = {effect.name: pulls(effect, experiment, 2) for effect in seen}
    far = {name: rms(values).__round__(2) for name, values in found.items() if rms(values) > 2.0}
    assert not far
    assert 0.85 <= rms(np.concatenate(list(found.values()))) <= 1.15


@pytest.mark.parametrize(("effect", "experiment"), CASES)
def test_the_balance_shows_the_effect_smoothly(effect: Effect, experiment: str) -> None:
    """Signatures exist at neutral: differences of two widths agree, and are not zero."""
    chain = chain_of([case_link(effect, experiment)])
    parameters = visible(chain, experiment)
    assert parameters.free.any()
    coarse = signatures(chain, experiment, parameters, 1e-3)
    fine = signatures(chain, experiment, parameters, 2.5e-4)
    np.testing.assert_allclose(coarse, fine, atol=2e-3 * float(np.abs(fine).max()))

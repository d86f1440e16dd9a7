"""The estimators' rows against the experiment's balance and the table of effects."""

from collections.abc import Iterator, Mapping

import numpy as np
import pytest

from footcal_cli.core.chain import chain_of, link
from footcal_cli.core.effects.body import ANGULAR_MOMENTUM, COM_OFFSET
from footcal_cli.core.effects.calibration import SCALE_BIAS
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.foot import HANGING_PLATE, PLATE_INERTIA
from footcal_cli.core.effects.transport import DELAY, SMOOTHING
from footcal_cli.core.experiments import contract, stand, walk
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.memory import believed, run_memory
from footcal_cli.core.online.noise import Guards, WalkNoise
from footcal_cli.core.online.rows import Rows, cell_rows
from footcal_cli.core.parameters import FloatArray
from tests.core.walk_data import Errors, make_standing, make_walk, record
from tests.core.walking import belief_of, stand_log, turned_world, walk_log


@pytest.fixture(scope="module")
def made() -> tuple[Log, Log, Rows, FloatArray]:
    """A short walk with raw counts, the same in believed newtons, its rows, and its yaw."""
    recording = record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2)
    log = walk_log(recording)
    belief = belief_of(recording)
    rows = cell_rows(log, belief, samples_per_update=1)
    newtons = log.with_readings(belief.forces(log.readings))
    return log, newtons, rows, belief.bias_sd_n


def along_the_heading(error: np.ndarray, log: Log) -> np.ndarray:
    """Errors (n, k) of the balance with (mx, my) along and across the mean yaw of the feet."""
    yaw = np.angle(np.exp(1j * log.known["foot_yaw_rad"]).sum(axis=1))
    moment = (error[:, 1] + 1j * error[:, 2]) * np.exp(-1j * yaw)
    return np.column_stack([error[:, 0], moment.real, moment.imag, error[:, 3:]])


def usable(rows: Rows) -> np.ndarray:
    """Samples away from the ends, where slopes of the reference are two-sided."""
    return (rows.time_s > 2.6) & (rows.time_s < 7.4)


def test_with_nothing_wrong_the_rows_are_the_experiments_balance(
    made: tuple[Log, Log, Rows, FloatArray],
) -> None:
    _, newtons, rows, _ = made
    balance = walk.EXPERIMENT.balance(newtons)
    assert rows.outputs == balance.outputs
    assert rows.valid.sum() > 1000
    np.testing.assert_array_equal(rows.valid, balance.valid)
    error = along_the_heading(balance.error, newtons)
    np.testing.assert_allclose(rows.error[rows.valid], error[balance.valid], atol=1e-10)


EXACT = Errors(
    gain_sd=0.0, bias_sd=0.0, gain_walk=0.0, bias_walk=0.0, quantum=0.0, white=0.0, slow=0.0,
    com_noise=0.0, acc_noise=0.0, rate_noise=0.0,
)  # fmt: skip


def derivatives_of_the_residual(
    experiment: Experiment, log: Log, rows: Rows, believed: Belief
) -> Iterator[tuple[str, FloatArray]]:
    """Each unknown of the rows, and the change of the one residual per unit of it, (n, k).

    The chain is the table's: calibration of every cell, body, plates and transport. A gain γ and a
    bias β on top of the belief are c = c⁰ (1 + γ) and d = d⁰ (1 + γ) + β.
    """
    effects = (SCALE_BIAS, HANGING_PLATE, DELAY, COM_OFFSET, ANGULAR_MOMENTUM)
    chain = chain_of(link(effect, log.channels) for effect in effects)
    belief = zip(log.channels, believed.scale_n_per_count, believed.bias_n, strict=True)
    calibration = {cell: (float(scale), float(bias)) for cell, scale, bias in belief}

    def error(unknown: str, size: float) -> FloatArray:
        owner, name = unknown.split(".")
        values = {f"{cell}.scale": scale for cell, (scale, _) in calibration.items()}
        values |= {f"{cell}.bias": bias for cell, (_, bias) in calibration.items()}
        if name == "gain":
            scale, bias = calibration[owner]
            values |= {f"{owner}.scale": scale * (1 + size), f"{owner}.bias": bias * (1 + size)}
        else:
            values[unknown] = values.get(unknown, 0.0) + size
        balance = contract.residual(experiment, chain, log, values)
        return along_the_heading(balance.error, log)

    for unknown in rows.names:
        step = 5e-4 if unknown == "robot.delay" else 1e-4
        yield unknown, (error(unknown, step) - error(unknown, -step)) / (2.0 * step)


COM_STATES = ("robot.com_correction_x", "robot.com_correction_y")
TOLERANCE = {"robot.delay": 1e-2, "robot.angmom_loss": 1e-4}
"""Share of the largest change. A delay is interpolated between samples, and the moment of a wrong
momentum is that of the demanded force, not of the cells'; all else is linear, and exact."""


@pytest.mark.parametrize("seed", [3, 4])
def test_every_column_of_a_walk_is_the_derivative_of_the_one_residual(seed: int) -> None:
    recording = record(make_walk(0.1, 6.0, seed=seed, turn=0.05), EXACT, seed=seed)
    log, belief = walk_log(recording), belief_of(recording)
    states = (*COM_STATES, "robot.angmom_loss", "robot.delay")
    rows = cell_rows(log, belief, samples_per_update=1, states=states)
    # the believed contact knows no transitions of the plate: judge away from them and the ends
    settled = np.isfinite(log.known["contact"]).all(axis=1)
    steady = (np.convolve(settled, np.ones(7), mode="same") == 7) & (rows.time_s > 1.0)
    use = rows.valid & (steady & (rows.time_s < 5.0))[:, None]
    assert use[:, 3:].any(axis=0).all(), "every cell swings"
    for name, change in derivatives_of_the_residual(walk.EXPERIMENT, log, rows, belief):
        i = rows.names.index(name)
        size = np.abs(change[use]).max()
        assert size > 0, name
        worst = np.abs(rows.h[:, :, i] / rows.prior_sd[i] - change)[use].max()
        assert worst < TOLERANCE.get(name, 1e-8) * size, name


@pytest.mark.parametrize("seed", [5, 6])
def test_every_column_of_a_stand_is_the_derivative_of_the_one_residual(seed: int) -> None:
    made = make_standing(4, seed, replace=True, lift=True)
    log, belief = stand_log(made), belief_of(made)
    rows = cell_rows(log, belief, samples_per_update=1, states=COM_STATES, plate=False, static=True)
    for name, change in derivatives_of_the_residual(stand.EXPERIMENT, log, rows, belief):
        i = rows.names.index(name)
        size = np.abs(change[rows.valid]).max()
        assert size > 0, name
        found = rows.h[:, :, i] / rows.prior_sd[i]
        assert np.abs(found - change)[rows.valid].max() < 1e-8 * size, name


@pytest.mark.parametrize(
    ("effect", "theta"),
    [
        (SMOOTHING, {"smoothing": 3e-4}),
        (SMOOTHING, {"smoothing_fourth": 1e-6}),
        (COM_OFFSET, {"com_correction_z": 0.004}),
    ],
)
def test_states_of_the_reference_are_effects_though_their_columns_are_of_the_cells(
    effect: Effect, theta: Mapping[str, float]
) -> None:
    """``error + H z`` of a changed reference is the error that there was before, cells exact.

    The columns take the whole moment of the cells for that of the CoM's acceleration: a walk
    without angular momentum, which would be noise in them.
    """
    recording = record(make_walk(0.1, 8.0, seed=2, swing=0.0), EXACT, seed=2)
    log, belief = walk_log(recording), belief_of(recording)
    values = {p: np.full(1, theta.get(p, 0.0)) for p in effect.parameter_names}
    changed, _ = effect.apply(log, values, None)
    before, rows = (cell_rows(x, belief, samples_per_update=1) for x in (log, changed))
    z = np.zeros(len(rows.names))
    for name, size in theta.items():
        at = rows.names.index(f"robot.{name}")
        z[at] = size / rows.prior_sd[at]
    use = (rows.valid & before.valid)[:, :3] & usable(rows)[:, None]
    wrong = (rows.error - before.error)[:, :3][use]
    left = (rows.error + rows.h @ z - before.error)[:, :3][use]
    assert np.sqrt(np.mean(left**2)) < 0.15 * np.sqrt(np.mean(wrong**2))


def test_a_block_is_the_mean_of_its_samples(made: tuple[Log, Log, Rows, FloatArray]) -> None:
    log, _, single, _ = made
    recording = record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2)
    blocks = cell_rows(log, belief_of(recording), samples_per_update=4)
    assert len(blocks) == len(single) // 4
    j = 100
    part = slice(4 * j, 4 * j + 4)
    assert single.valid[part, 0].all()
    np.testing.assert_allclose(blocks.error[j, 0], single.error[part, 0].mean())
    np.testing.assert_allclose(blocks.h[j, 0], single.h[part, 0].mean(axis=0))
    assert blocks.last_sample[j] == 4 * j + 3


def test_rows_do_not_depend_on_how_the_log_is_cut_into_chunks(
    monkeypatch: pytest.MonkeyPatch, made: tuple[Log, Log, Rows, FloatArray]
) -> None:
    log, _, whole, _ = made
    recording = record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2)
    monkeypatch.setattr("footcal_cli.core.online.rows._CHUNK_ROWS", 37)
    cut = cell_rows(log, belief_of(recording), samples_per_update=1)
    np.testing.assert_array_equal(cut.valid, whole.valid)
    np.testing.assert_allclose(cut.h, whole.h, rtol=1e-12, atol=1e-15)


def test_noise_of_a_cell_in_the_air_says_nothing_of_its_gain() -> None:
    """Regressed on its own reading a gain is as surely −1 as the noise is all that is read."""
    recording = record(make_walk(0.1, 20.0, seed=2), Errors(), seed=2)
    log, belief = walk_log(recording), belief_of(recording)
    sd = 2.0 / np.abs(belief.scale_n_per_count)
    noise = np.random.default_rng(5).normal(size=log.readings.shape) * sd
    slopes = {}
    for neighbours in (False, True):
        rows = cell_rows(log.with_readings(log.readings + noise), belief, samples_per_update=1,
                         neighbours=neighbours)  # fmt: skip
        own = []
        for k in range(len(log.channels)):
            use = rows.valid[:, rows.totals + k]
            gain = rows.h[use, rows.totals + k, k] / rows.prior_sd[k]
            error = rows.error[use, rows.totals + k]
            own.append(-np.cov(gain, error)[0, 1] / np.var(gain))
        slopes[neighbours] = float(np.mean(own))
        totals = slice(0, rows.totals)
        assert np.isfinite(rows.h[:, totals]).all()
    assert slopes[False] == pytest.approx(-1.0, abs=0.02)
    assert slopes[True] == pytest.approx(0.0, abs=0.15)


def test_an_offset_of_the_com_stays_unless_it_would_stand_for_an_unknown_momentum() -> None:
    """Fixed at zero, the offset would go into the scales: left cells against right ones."""
    recording = record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2)
    log = walk_log(recording)
    still = log.with_known(angmom_rate_nm=np.zeros_like(log.known["angmom_rate_nm"]))
    kept = [
        believed(cell_rows(one, belief_of(recording)), WalkNoise(), Guards(), repeated=10.0).names
        for one in (log, still)
    ]
    assert ["robot.com_correction_y" in names for names in kept] == [True, False]


def test_a_walk_s_calibration_does_not_depend_on_the_heading() -> None:
    """Guards of single rows along the world's axes once moved it by up to 0.1 sd."""
    recording = record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2)
    log, belief = walk_log(recording), belief_of(recording)
    elsewhere = turned_world(log, 2.0, np.array([30.0, -70.0]))
    first, second = (run_memory(one, belief).track for one in (log, elsewhere))
    assert first.names == second.names
    assert np.all(np.abs(second.values - first.values) < 1e-4 * first.sd)


def test_the_mass_below_the_cells_is_the_effect_of_a_plates_inertia(
    made: tuple[Log, Log, Rows, FloatArray],
) -> None:
    """Rows move with the mass as the balance of a log without that inertia does."""
    log, newtons, _, _ = made
    rng = np.random.default_rng(3)
    acc = rng.normal(0.0, 2.0, (len(log), 2, 3))
    log, newtons = (one.with_known(foot_acc_mps2=acc) for one in (log, newtons))
    belief = belief_of(record(make_walk(0.1, 8.0, seed=2, turn=0.05), Errors(), seed=2))
    rows = cell_rows(log, belief, samples_per_update=1)
    removed, _ = PLATE_INERTIA.remove(newtons, {"plate_mass": np.array([0.1, 0.0])}, None)
    change = along_the_heading(
        walk.EXPERIMENT.balance(removed).error - walk.EXPERIMENT.balance(newtons).error, newtons
    )
    at = rows.names.index("left.plate_mass")
    found = rows.h[:, :, at] * (0.1 / rows.prior_sd[at])
    np.testing.assert_allclose(found[rows.valid], change[rows.valid], atol=1e-10)

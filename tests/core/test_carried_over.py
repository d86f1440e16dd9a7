"""What the low-pass of the readings carries from stances into swings, and where it is taken off."""

import numpy as np
import pytest

from footcal_cli.core.contact import carried_over, detect_contact
from footcal_cli.core.online.rows import cell_rows
from footcal_cli.core.online.six_axis import six_axis_rows
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import low_pass
from tests.core.test_online_six_axis import six_axis_walk
from tests.core.walk_data import Errors, make_walk, record
from tests.core.walking import belief_of, walk_log

WEIGHT_N, CUTOFF_HZ = 50.0, 10.0
LEVEL_N = np.array([0.3, -1.2])


def steps(rate_hz: float, swing_s: float) -> tuple[FloatArray, FloatArray]:
    """A minute of stances that end smoothly, and of what a swung plate adds: N, (n,) each."""
    time_s = np.arange(0.0, 60.0, 1.0 / rate_hz)
    period, ramp = 2.0 * swing_s + 0.4, 0.12
    at = np.mod(time_s, period)
    rise = np.clip((at - swing_s) / ramp, 0.0, 1.0) * np.clip((period - at) / ramp, 0.0, 1.0)
    load = WEIGHT_N * rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2)
    inertia = 0.4 * np.where(at < swing_s, np.sin(np.pi * at / swing_s) ** 2, 0.0)
    return load, inertia


@pytest.mark.parametrize(("rate_hz", "swing_s"), [(30.0, 0.3), (100.0, 0.3), (400.0, 0.5)])
def test_a_swing_reads_its_level_whatever_the_stances_around_it_weigh(
    rate_hz: float, swing_s: float
) -> None:
    load, inertia = steps(rate_hz, swing_s)
    share = np.array([0.3, 0.7])
    readings = LEVEL_N + (load + inertia)[:, None] * share
    good = np.ones(load.size, dtype=bool)
    filtered = low_pass(readings, rate_hz, CUTOFF_HZ)
    contact = detect_contact(filtered.sum(axis=1)[:, None], WEIGHT_N, rate_hz)
    carried = carried_over(readings, good, contact, [np.arange(2)], rate_hz, CUTOFF_HZ)
    air = contact[:, 0] == 0.0
    assert air.sum() > 0.05 * load.size
    assert not carried[~air].any(), "stances stay as they are"
    # what is left is the level and the plate, filtered as the motion is
    expected = LEVEL_N + low_pass(inertia, rate_hz, CUTOFF_HZ)[:, None] * share
    before, after = (np.abs(x - expected)[air].max() for x in (filtered, filtered - carried))
    assert before > 5e-4 * WEIGHT_N
    assert after < 0.25 * before


def test_lost_samples_and_feet_that_never_swing_carry_nothing() -> None:
    load, _ = steps(100.0, 0.3)
    readings = np.stack([LEVEL_N[0] + load, np.full(load.size, WEIGHT_N)], axis=1)
    good = np.ones(load.size, dtype=bool)
    good[700:720] = False
    readings[~good] = np.nan
    contact = detect_contact(readings, WEIGHT_N, 100.0)
    carried = carried_over(
        readings, good, contact, [np.array([0]), np.array([1])], 100.0, CUTOFF_HZ
    )
    assert np.isfinite(carried).all()
    assert carried[:, 0].any()
    assert not carried[:, 1].any()
    assert not carried[~good].any()


def test_it_is_taken_off_what_is_in_the_air_and_stays_in_the_totals() -> None:
    recording = record(make_walk(0.1, 8.0, seed=2), Errors(), seed=2)
    belief = belief_of(recording)
    cells, (ankles, _) = walk_log(recording), six_axis_walk(2)
    for log, make, per_unit in (
        (cells, lambda one: cell_rows(one, belief), belief.scale_n_per_count),
        (ankles, six_axis_rows, np.ones(12)),
    ):
        each = 1.0 + np.arange(log.readings.shape[1])
        carried = np.tile(each, (len(log), 1))
        plain, known = make(log), make(log.with_known(carried_over=carried))
        taken, own = plain.error - known.error, plain.totals
        assert not taken[:, :own].any()
        in_the_air = plain.valid[:, own:]
        assert in_the_air.any(axis=0).all()
        expected = np.broadcast_to(each * per_unit, in_the_air.shape)[in_the_air]
        np.testing.assert_allclose(taken[:, own:][in_the_air], expected, rtol=1e-6)

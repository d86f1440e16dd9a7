import numpy as np
import pytest

from footcal_cli.core.contact import (
    ContactRule,
    Reason,
    airborne,
    detect_contact,
    gait_cycles,
    judge,
)
from footcal_cli.core.signals import (
    autocorrelation_time,
    clock_of,
    interpolate_stream,
    low_pass,
    low_pass_stretches,
    stretches,
)


def test_the_clock_counts_what_is_wrong_with_its_stamps() -> None:
    time = np.array([0.0, 0.1, 0.1, 0.2, 0.15, 0.3, 0.9, 1.0, 1.1])
    clock = clock_of(time)
    assert clock.keep.tolist() == [0, 1, 3, 5, 6, 7, 8]
    assert (clock.duplicates, clock.backward, clock.gaps, clock.missing) == (1, 1, 1, 5)
    assert clock.longest_gap_s == pytest.approx(0.6)
    assert clock.period_s == pytest.approx(0.1)


def test_interpolation_is_linear_and_invents_nothing_over_gaps_or_ends() -> None:
    time = np.array([0.0, 0.1, 0.2, 0.8, 0.9])
    values = np.stack([3 * time + 1, time**0], axis=1)
    at = np.array([-0.01, 0.0, 0.05, 0.2, 0.5, 0.85, 0.9, 0.95])
    merged, good = interpolate_stream(time, values, at, max_gap_s=0.15)
    assert good.tolist() == [False, True, True, True, False, True, True, False]
    np.testing.assert_allclose(merged[good, 0], 3 * at[good] + 1, atol=1e-12)


def test_a_lost_sample_spoils_only_what_needs_it() -> None:
    time = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    values = np.array([[0.0], [1.0], [np.nan], [3.0], [4.0]])
    _, good = interpolate_stream(time, values, np.array([0.05, 0.1, 0.15, 0.3]), max_gap_s=1.0)
    assert good.tolist() == [True, True, False, True]


def test_the_zero_phase_low_pass_keeps_slow_signals_in_place_and_halves_its_cut_off() -> None:
    t = np.arange(4000) / 80.0
    slow = np.sin(2 * np.pi * 1.0 * t)
    edge = np.sin(2 * np.pi * 10.0 * t)
    middle = slice(400, -400)
    assert np.abs(low_pass(slow, 80.0) - slow)[middle].max() < 2e-3
    # forward and backward: 1/sqrt(2) twice
    assert np.abs(low_pass(edge, 80.0))[middle].max() == pytest.approx(0.5, abs=0.01)


def test_the_causal_low_pass_sees_no_future_and_starts_steady() -> None:
    rng = np.random.default_rng(0)
    signal = rng.normal(size=(300, 2))
    whole = low_pass(signal, 80.0, causal=True)
    changed = signal.copy()
    changed[200:] += 5.0
    np.testing.assert_array_equal(low_pass(changed, 80.0, causal=True)[:200], whole[:200])
    level = low_pass(np.full((50, 1), 7.0), 80.0, causal=True)
    np.testing.assert_allclose(level, 7.0, atol=1e-9)


def test_filtering_in_stretches_does_not_reach_over_a_gap() -> None:
    values = np.zeros((200, 1))
    values[100:] = 1e6
    good = np.ones(200, dtype=bool)
    good[95:105] = False
    filtered = low_pass_stretches(values, good, 80.0)
    np.testing.assert_allclose(filtered[:95], 0.0, atol=1e-6)
    np.testing.assert_allclose(filtered[105:], 1e6)
    assert np.isnan(filtered[95:105]).all()


def test_autocorrelation_time_of_a_first_order_process_is_the_closed_form() -> None:
    rng = np.random.default_rng(4)
    decay, n = 0.9, 200_000
    x = np.empty(n)
    x[0] = 0.0
    noise = rng.normal(size=n)
    for k in range(1, n):
        x[k] = decay * x[k - 1] + noise[k]
    closed = (1 + decay) / (1 - decay)
    assert autocorrelation_time(x) == pytest.approx(closed, rel=0.1)
    stretches = np.repeat(np.arange(200), n // 200)
    assert autocorrelation_time(x, stretches) == pytest.approx(closed, rel=0.1)
    # stretches in another order are no neighbours: nothing across a gap counts
    mixed = np.concatenate(rng.permutation(x.reshape(200, -1)))
    assert autocorrelation_time(mixed, stretches) == pytest.approx(closed, rel=0.1)
    assert autocorrelation_time(rng.normal(size=5000)) == pytest.approx(1.0, rel=0.1)


def steps(bias: float) -> tuple[np.ndarray, np.ndarray]:
    """Two seconds of stance and swing by turns at 80 Hz, and the truth."""
    t = np.arange(960)
    loaded = (t // 120) % 2 == 0
    force = np.where(loaded, 50.0, 0.0)
    kernel = np.ones(5) / 5
    return np.convolve(force, kernel, mode="same") + bias, loaded


@pytest.mark.parametrize("bias", [-2.0, 0.0, 2.5])
def test_contact_is_found_whatever_the_bias(bias: float) -> None:
    force, loaded = steps(bias)
    rng = np.random.default_rng(1)
    noisy = force + rng.normal(0.0, 0.2, force.size)
    found = detect_contact(noisy[:, None], 52.0, 80.0)[:, 0]
    known = np.isfinite(found)
    assert np.array_equal(found[known] == 1, loaded[known])
    assert known.mean() > 0.85


def test_chatter_around_the_threshold_is_not_contact() -> None:
    rule = ContactRule()
    force = np.full(400, 0.5 * rule.on_share * 52.0)
    force[:100] = 50.0
    force[200:203] = 2.0 * rule.on_share * 52.0
    found = detect_contact(force[:, None], 52.0, 80.0, rule)[:, 0]
    assert (found[120:] == 0).all()


def test_a_transition_belongs_to_the_nearer_phase_when_weight_is_shared_out() -> None:
    contact = np.array([1, 1, np.nan, np.nan, np.nan, np.nan, 0, 0, 0], dtype=float)[:, None]
    hanging = airborne(contact)[:, 0]
    assert hanging[0] == 0.0
    assert hanging[-1] == pytest.approx(1.0)
    assert (np.diff(hanging) >= -1e-12).all()
    assert hanging[:5].sum() == pytest.approx((1 - hanging[4:]).sum(), abs=1.0)


def test_gait_cycles_start_where_a_foot_lands() -> None:
    contact = np.array([1, 1, np.nan, 0, 0, np.nan, 1, 1, 0, 1], dtype=float)[:, None]
    assert gait_cycles(contact).tolist() == [-1, -1, -1, -1, -1, -1, 0, 0, 0, 1]


def test_every_rejected_sample_has_one_reason_and_they_add_up() -> None:
    n = 10
    dropout = np.zeros(n, dtype=bool)
    dropout[:3] = True
    moving = np.zeros(n, dtype=bool)
    moving[2:6] = True
    verdict = judge({Reason.TRANSITION: moving, Reason.DROPOUT: dropout}, n)
    assert verdict.counts == {"dropout": 3, "transition": 3}
    assert verdict.valid.sum() + sum(verdict.counts.values()) == n
    assert verdict.words()[2] == "dropout"
    assert verdict.words()[9] == ""


def test_stretches_are_half_open_runs() -> None:
    assert stretches(np.array([True, True, False, True])) == [(0, 2), (3, 4)]

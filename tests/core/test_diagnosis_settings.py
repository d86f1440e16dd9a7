"""What differs between hangings, and between the turns of one: each has its own share of blame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.diagnosis.engine import diagnose
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.inference.between_settings import Shown, variance_between
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.settings import (
    Parts,
    Settings,
    beside_settings,
    part_variances,
    repeated,
    row_levels,
    whiten_parts,
)
from footcal_cli.core.inference.settled import settled
from footcal_cli.core.inference.shapes import possible_times
from footcal_cli.core.inference.whitening import fit_row_whitener
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

SETTINGS, TURNS, ROWS = 8, 10, 40
OF_TURN, OF_SETTING = 0.3, 0.8


def drawn(seed: int) -> tuple[Settings, FloatArray, list[Parts]]:
    """One output of one leg: offsets that differ from turn to turn and from hanging to hanging."""
    rng = np.random.default_rng(seed)
    number = np.repeat(np.arange(SETTINGS), TURNS * ROWS)
    part = np.repeat(np.arange(SETTINGS * TURNS), ROWS)
    settings = Settings(
        number, np.ones((number.size, 1)), np.zeros(1, dtype=np.int64), 0 * number, part
    )
    noise = rng.standard_normal(number.size) + OF_TURN * rng.standard_normal(part.max() + 1)[part]
    noise += OF_SETTING * rng.standard_normal(SETTINGS)[number]
    return settings, noise, settings.parts(0 * number, np.arange(number.size))


def whitened(settings: Settings, noise: FloatArray, parts: list[Parts]) -> FloatArray:
    """Noise, loose column and noise again as a residual, whitened for both levels."""
    common = np.ones((noise.size, 1))
    every = settings.rows(np.arange(noise.size))
    left = beside_settings(common, noise, settings.columns, every, settings.shown)
    variances = part_variances(left, settings.columns, parts)
    both = np.column_stack([settings.columns, common, noise])
    whiten_parts(both, settings.columns, parts, variances)
    loose, rest = both[:, :1], both[:, 1:]
    kept: IntArray = np.arange(noise.size)
    groups = settings.rows(kept)
    variance = variance_between(rest[:, :1], loose, rest[:, -1], groups, settings.kind)
    return repeated(rest, loose, groups, variance)


def test_every_part_of_a_setting_is_a_group_of_its_own() -> None:
    _, _, parts = drawn(0)
    assert len(parts) == 1, "one output of one sensor"
    assert len(parts[0].groups) == SETTINGS * TURNS
    assert all(rows.size == ROWS for rows in parts[0].groups)


def test_settings_without_parts_are_as_they_were() -> None:
    settings, _, _ = drawn(0)
    bare = Settings(settings.number, settings.columns, settings.kind)
    assert bare.parts(0 * settings.number, np.arange(settings.number.size)) == []


def test_what_is_whitened_counts_every_turn_once() -> None:
    """Sums over a turn have variance 1 per row, whatever hanging they are from: none is doubled."""
    sums = []
    for seed in range(30):
        settings, noise, parts = drawn(seed)
        white = whitened(settings, noise, parts)[:, -1]
        turns = white.reshape(SETTINGS * TURNS, ROWS).sum(axis=1) / np.sqrt(ROWS)
        sums.append(np.mean(turns**2))
    # the upper value of a variance makes the sums a little too small, never too large
    assert 0.6 < float(np.mean(sums)) < 1.1


def test_rows_are_as_noisy_as_their_own_setting() -> None:
    """A quiet hanging and a loud one; a load that stands still takes no freedom of its own."""
    settings, noise, _ = drawn(0)
    loud = np.where(settings.number == 2, 3.0, 1.0)
    still = np.hstack([settings.columns, settings.columns * (1.0 + 1e-12 * noise[:, None])])
    kept: IntArray = np.arange(noise.size)
    both = Settings(settings.number, still, np.arange(2), settings.sensor, settings.part)
    level = row_levels(loud * noise, still, both.parts(0 * settings.number, kept))
    np.testing.assert_allclose(level, loud, rtol=0.15)


def test_variance_between_settings_is_seldom_taken_too_small() -> None:
    """Offsets of sd 0.8 in eight settings; and none: an upper value, in nine of ten draws."""
    above = []
    for true in (OF_SETTING, 0.0):
        found = []
        for seed in range(40):
            settings, _, _ = drawn(seed)
            rng = np.random.default_rng(100 + seed)
            noise = rng.standard_normal(settings.number.size)
            noise += true * rng.standard_normal(SETTINGS)[settings.number]
            groups = settings.rows(np.arange(noise.size))
            found.append(
                variance_between(
                    np.ones((noise.size, 1)), settings.columns, noise, groups, settings.kind
                )[0]
            )
        above.append(float(np.mean(np.array(found) >= true**2)))
        # in units of what a whole setting tells: 1 where nothing differs
        assert float(np.median(found)) < 5.0 * max(true**2, 1.0 / (TURNS * ROWS))
    assert above[0] >= 0.8
    assert above[1] == 1.0


def test_a_step_is_looked_for_in_pauses_and_between() -> None:
    """Two spells of 100 s, a pause of 60 s: the pause is one moment, where the second starts."""
    spell = np.arange(0.0, 100.0, 0.5)
    time_s = 1000.0 + np.concatenate([spell, spell + 160.0])
    rows = time_s.size
    log = Log("hang", ("fl.fx",), time_s, np.zeros((rows, 1)), {}, np.zeros(rows, dtype=np.int64))
    times = possible_times(log, (0.25, 0.499, 0.75))
    np.testing.assert_allclose(times, [50.0, 160.0, 210.0])


OUTPUTS = 3


def hung(seed: int, size: float) -> Problem:
    """Eight hangings of two legs, four each; a gain of one axis of one leg may be hidden.

    Loads stand still within a hanging, so that a gain is a contrast of four offsets. Every hanging
    repeats an axis to a tenth of its noise only.
    """
    rng = np.random.default_rng([17, seed])
    setting = np.repeat(np.arange(SETTINGS), TURNS * OUTPUTS)
    output = np.tile(np.arange(OUTPUTS), SETTINGS * TURNS)
    # each axis up in two hangings of a leg and down in two
    signs = rng.permuted(np.tile([-1.0, 1.0], (OUTPUTS, 2, SETTINGS // 4)), axis=-1)
    down = signs.reshape(OUTPUTS, SETTINGS).T + 0.3 * rng.normal(size=(SETTINGS, OUTPUTS))
    load = down[setting, output]
    axis = np.eye(OUTPUTS)[output]
    leg = np.eye(2)[setting // (SETTINGS // 2)]
    own = (leg[:, :, None] * axis[:, None, :]).reshape(setting.size, -1)
    gains = own * load[:, None]
    residual = rng.normal(size=setting.size) + size * gains[:, 0]
    residual += (0.1 * rng.normal(size=(SETTINGS, OUTPUTS)))[setting, output]
    loose = np.hstack([axis, axis * load[:, None]])
    turn = np.arange(setting.size) // OUTPUTS
    # what no hanging hides: of so many one stands out more than an effect that is
    others = rng.normal(size=(SETTINGS * TURNS, 400))[turn] * axis[:, [1]]
    columns = np.hstack([gains, others])
    return Problem(
        residual=residual,
        calibration=own,
        columns=columns,
        signatures=(Signature("", "", "", ""),) * columns.shape[1],
        block=turn,
        output=output,
        sequence=np.arange(setting.size),
        outputs=("fx", "fy", "fz"),
        units=("N",) * OUTPUTS,
        noise=np.ones(setting.size),
        tolerance=np.full(OUTPUTS, 0.1),
        settings=Settings(setting, loose, np.repeat([0, 1], OUTPUTS)),
    )


def law_of(problem: Problem) -> FloatArray:
    """Variances of offsets and gains between hangings, rows as they are."""
    kept = np.arange(problem.residual.size)
    law = settled(problem, lambda columns: columns, kept)
    assert law is not None
    return law.variance[[0, -1]]


@pytest.mark.slow
def test_an_effect_does_not_hide_behind_the_variance_that_it_makes() -> None:
    """With a gain hidden, variances are what they are without it; not fitted, they are tenfold."""
    clean, hidden, blind = [], [], []
    for seed in range(12):
        clean.append(law_of(hung(seed, 0.0)).max())
        hidden.append(law_of(hung(seed, 2.0)).max())
        blind.append(law_of(hung(seed, 2.0).without_candidates).max())
    assert np.median(blind) > 10.0 * np.median(clean)
    assert np.mean(np.array(hidden) < 0.2 * np.array(blind)) >= 0.9


def test_few_rows_are_as_noisy_as_they_are_about_one_calibration() -> None:
    """However far off the calibration stands: no placement has rows enough for one of its own."""
    few = hung(0, 0.0)
    far = replace(few, residual=few.residual + 50.0 * few.calibration.sum(axis=1))
    near, off = fit_row_whitener(few).sd, fit_row_whitener(far).sd
    np.testing.assert_allclose(off, near, rtol=1e-9)
    np.testing.assert_allclose(near, 1.0, rtol=0.3)


def test_what_settings_leave_is_that_of_one_regression_on_all_their_columns() -> None:
    rng = np.random.default_rng(3)
    number = np.repeat(np.arange(5), 60)
    columns = np.column_stack([np.ones(300), rng.standard_normal(300), number < 4])
    settings = Settings(number, columns, np.array([0, 1, 2]))
    common = np.column_stack([rng.standard_normal((300, 4)), number == 2])
    residual = rng.standard_normal(300)
    every = settings.rows(np.arange(300))
    left = beside_settings(common, residual, columns, every, settings.shown)
    shown = columns * settings.shown[number]
    own = (np.eye(5)[number][:, :, None] * shown[:, None, :]).reshape(300, -1)
    whole = np.hstack([common, own])
    expected = residual - whole @ np.linalg.lstsq(whole, residual, rcond=1e-9)[0]
    assert left == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("log_variance", [-9.0, -2.0, 0.0, 4.0])
def test_predictions_of_settings_scatter_as_the_eigenvalues_say(log_variance: float) -> None:
    """``û = v (I + v M)⁻¹ b`` and Satterthwaite's sums, with M as one matrix."""
    rng = np.random.default_rng(5)
    own, score = rng.uniform(1.0, 9.0, 12), rng.standard_normal(12)
    common = 0.4 * rng.standard_normal((12, 3))
    m, v = np.diag(own) - common @ common.T, np.exp(log_variance)
    share = v * np.linalg.eigvalsh(m) / (1.0 + v * np.linalg.eigvalsh(m))
    found = np.linalg.solve(np.eye(12) + v * m, score)
    one, two = share.sum(), np.sum(share**2)
    expected = v * found @ found - two / one * stats.chi2.ppf(0.1, one**2 / two)
    assert Shown(own, common, score).more(log_variance) == pytest.approx(expected, rel=1e-6)


SHAPE = np.array([0.0] * 7 + [0.4, 1.0, 1.0])
"""A change over ten turns, most of it between the eighth and the ninth."""


def late_change(seed: int, size: float) -> FloatArray:
    """Family-wise p of such a change in each hanging; the fourth has one."""
    settings, noise, _ = drawn(seed)
    assert settings.part is not None
    own = settings.number[:, None] == np.arange(SETTINGS)
    columns = own * SHAPE[settings.part % TURNS][:, None]
    n = noise.size
    problem = Problem(
        residual=noise + size * columns[:, 3], calibration=np.ones((n, 1)), columns=columns,
        signatures=tuple(Signature("offset_change", "fx", f"{s}", "N") for s in range(SETTINGS)),
        block=settings.part, output=0 * settings.number, sequence=settings.part, outputs=("fx",),
        units=("N",), noise=np.ones(n), tolerance=np.array([0.01]), rate_hz=4.0, settings=settings,
    )  # fmt: skip
    found = diagnose(problem, Rules(), seed).search.first
    # what two turns know most of is known by three of equal weight: signs reach p = 2⁻², no less
    assert 3.0 <= found.informative[3] < 4.0
    return found.p


@pytest.mark.parametrize(
    ("hidden", "clean"), [(2, 10), pytest.param(4, 24, marks=pytest.mark.slow)]
)
def test_a_change_that_two_turns_know_most_of_is_judged_by_the_scatter_of_all(
    hidden: int, clean: int
) -> None:
    """Of turns with sd ``√(0.3² + 1/40)`` its size has sd ``0.34 / |s − s̄|``."""
    sd = np.sqrt(OF_TURN**2 + 1.0 / ROWS) / np.linalg.norm(SHAPE - SHAPE.mean())
    found = np.array([late_change(seed, 7.0 * sd) for seed in range(hidden)])
    assert np.all(found[:, 3] < 0.01)
    assert np.all(np.delete(found, 3, axis=1) > 0.01)
    least = np.array([late_change(seed, 0.0).min() for seed in range(clean)])
    assert np.sum(least < 0.01) <= 1

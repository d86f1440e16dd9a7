"""Scale and bias of a cell: the published table, closed forms, and consistency over seeds."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.bench.regression import AffineFit, Method, fit_affine, pooled_curvature
from footcal_cli.core.parameters import FloatArray
from footcal_cli.errors import FitError

GRAVITY_MPS2 = 9.80665
SCALE, BIAS = -2.4e-5, 200.0


def table2(repository: Path) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Loads in kg and counts per channel, as printed."""
    rows: dict[str, list[tuple[float, float]]] = defaultdict(list)
    with (repository / "sample_data/nao_table2/weights.csv").open() as stream:
        for row in csv.DictReader(stream):
            rows[row["channel"]].append((float(row["load_kg"]), float(row["counts"])))
    return {name: (np.array(r)[:, 0], np.array(r)[:, 1]) for name, r in rows.items()}


def printed(repository: Path) -> dict[str, tuple[float, float]]:
    path = repository / "sample_data/nao_table2/printed_coefficients.csv"
    with path.open() as stream:
        return {
            row["channel"]: (float(row["scale_kg_per_count"]), float(row["bias_kg"]))
            for row in csv.DictReader(stream)
        }


def test_all_16_printed_coefficients_come_out_to_8_digits(repository: Path) -> None:
    readings, coefficients = table2(repository), printed(repository)
    assert len(coefficients) == 8
    for channel, (scale, bias) in coefficients.items():
        load_kg, counts = readings[channel]
        fit = fit_affine(channel, load_kg * GRAVITY_MPS2, counts)
        assert fit.scale_n_per_count / GRAVITY_MPS2 == pytest.approx(scale, rel=1e-8)
        assert fit.bias_n / GRAVITY_MPS2 == pytest.approx(bias, rel=1e-8)


def test_table_2_bends_the_same_way_in_every_channel(repository: Path) -> None:
    fits = [fit_affine(c, kg * GRAVITY_MPS2, s) for c, (kg, s) in table2(repository).items()]
    curvature = pooled_curvature(fits)
    assert curvature is not None
    assert curvature.same_sign == 8
    assert curvature.sign_p == pytest.approx(2 * 0.5**8)
    # METHODS: residuals of left_rl are +9.6, +0.2, −15.5, +5.7 g as known − measured
    left_rl = next(fit for fit in fits if fit.channel == "left_rl")
    grams = -1e3 * left_rl.residual_n / GRAVITY_MPS2
    np.testing.assert_allclose(grams, [9.6, 0.2, -15.5, 5.7], atol=0.05)


def bench(seed: int, repeats: int = 5, noise_n: float = 0.02) -> tuple[FloatArray, FloatArray]:
    """Loads and counts of a cell that is exactly affine."""
    rng = np.random.default_rng(seed)
    load = np.repeat([0.0, 1.0, 2.0, 5.0, 10.0, 20.0], repeats)
    counts = (load - BIAS) / SCALE + noise_n / abs(SCALE) * rng.standard_normal(load.size)
    return load, counts


@pytest.mark.parametrize(
    "method", ["ordinary", "weighted", pytest.param("robust", marks=pytest.mark.slow)]
)
def test_truth_is_recovered_consistently(method: Method) -> None:
    z, inside = [], 0
    for seed in range(300):
        fit = fit_affine("left_fl", *bench(seed), method)
        z.append((fit.scale_n_per_count - SCALE) / fit.estimates.sd[0])
        inside += int(fit.ci95[0, 0] <= SCALE <= fit.ci95[0, 1])
    rms = float(np.sqrt(np.mean(np.square(z))))
    assert 0.9 < rms < 1.18  # 28 dof: the t statistic has sd 1.04, its rms over 300 seeds ± 0.04
    low, high = stats.binom.ppf(np.array([0.001, 0.999]), 300, 0.95) / 300
    assert low <= inside / 300 <= high


def test_a_misread_weight_moves_least_squares_but_not_the_robust_fit() -> None:
    load, counts = bench(1)
    load = load.copy()
    load[-1] += 3.0
    ordinary = fit_affine("c", load, counts, "ordinary")
    robust = fit_affine("c", load, counts, "robust")
    assert abs(ordinary.scale_n_per_count / SCALE - 1) > 5e-3
    assert abs(robust.scale_n_per_count / SCALE - 1) < 2e-3


def test_lack_of_fit_has_its_level_and_finds_a_curve() -> None:
    p = [lack(fit_affine("c", *bench(seed))) for seed in range(300)]
    assert stats.kstest(p, "uniform").pvalue > 0.01
    load, counts = bench(3)
    bent = counts + 1e-3 * load * (20.0 - load) / SCALE  # 0.5 % of 20 N at mid-load
    assert lack(fit_affine("c", load, bent)) < 1e-3


def lack(fit: AffineFit) -> float:
    assert fit.lack_of_fit is not None
    return fit.lack_of_fit.p


def test_readings_of_a_load_that_lies_still_are_one() -> None:
    """Ten readings share the seat's error: the level of the test is that of 18 placings."""
    found = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        load = np.repeat(np.tile([0.0, 10.0, 20.0, 30.0, 20.0, 10.0], 3), 10)
        seat = np.repeat(rng.normal(scale=0.05, size=18), 10)
        counts = 1000.0 * (load + seat + rng.normal(scale=0.01, size=load.size))
        found.append(lack(fit_affine("cell", load, counts)))
    assert np.mean(np.array(found) < 0.05) < 0.12


def test_single_readings_have_no_lack_of_fit_test() -> None:
    assert fit_affine("c", *bench(0, repeats=1)).lack_of_fit is None


def test_bow_is_the_sagitta_of_a_parabola() -> None:
    load = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    u = load / 4.0
    bow = 0.03
    counts = 1e5 * (u + 4.0 * bow * u * (1.0 - u))  # midpoint lies `bow` above the chord
    assert fit_affine("c", load, counts).bow == pytest.approx(bow, rel=1e-9)
    assert fit_affine("c", load, 1e5 - counts).bow == pytest.approx(bow, rel=1e-9)


def test_one_load_or_a_dead_channel_is_refused_in_words() -> None:
    with pytest.raises(FitError, match="fewer than two distinct loads"):
        fit_affine("c", np.array([1.0, 1.0]), np.array([5.0, 6.0]))
    with pytest.raises(FitError, match="never changes"):
        fit_affine("c", np.array([0.0, 1.0]), np.array([5.0, 5.0]))


def test_two_readings_give_a_line_without_an_interval() -> None:
    fit = fit_affine("c", np.array([0.0, 1.0]), np.array([0.0, 100.0]))
    assert fit.scale_n_per_count == pytest.approx(0.01)
    assert np.isnan(fit.estimates.sd).all()

"""Tails and quantiles against those of `scipy.stats`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray

RNG = np.random.default_rng(0)
SIZES: FloatArray = np.r_[-3.0, 0.0, 1e-300, 10.0 ** RNG.uniform(-8, 4, 500), np.inf, np.nan]
SIGNED: FloatArray = np.r_[5.0 * RNG.normal(size=500), 1e3, -1e3, np.inf, -np.inf, np.nan]
SHARES: FloatArray = np.r_[1e-300, 10.0 ** RNG.uniform(-12, 0, 500), 1.0 - 1e-12]
FREEDOM: FloatArray = np.array([-1.0, 0.0, 0.5, 1.0, 3.0, 17.0, 400.0])[:, None]
BELOW: FloatArray = np.array([1.0, 5.0, 80.0])[:, None, None]


@pytest.mark.parametrize(
    ("ours", "theirs", "arguments"),
    [
        (chances.chi2_sf, stats.chi2.sf, (SIZES, FREEDOM)),
        (chances.chi2_cdf, stats.chi2.cdf, (SIZES, FREEDOM)),
        (chances.chi2_isf, stats.chi2.isf, (SHARES, FREEDOM)),
        (chances.chi2_ppf, stats.chi2.ppf, (SHARES, FREEDOM)),
        (chances.ncx2_cdf, stats.ncx2.cdf, (SIZES, FREEDOM, 2.5)),
        (chances.f_sf, stats.f.sf, (SIZES, FREEDOM, BELOW)),
        (chances.f_ppf, stats.f.ppf, (SHARES, FREEDOM, BELOW)),
        (chances.t_sf, stats.t.sf, (SIGNED, FREEDOM)),
        (chances.t_logcdf, stats.t.logcdf, (SIGNED, FREEDOM)),
        (chances.t_ppf, stats.t.ppf, (SHARES, FREEDOM)),
        (chances.norm_sf, stats.norm.sf, (SIGNED,)),
        (chances.norm_isf, stats.norm.isf, (SHARES,)),
        (chances.norm_ppf, stats.norm.ppf, (SHARES,)),
    ],
)
def test_they_are_the_same(
    ours: Callable[..., Any], theirs: Callable[..., Any], arguments: tuple[Any, ...]
) -> None:
    np.testing.assert_allclose(ours(*arguments), theirs(*arguments), rtol=1e-14)


def test_of_cauchy() -> None:
    np.testing.assert_allclose(
        chances.cauchy_logpdf(SIGNED, 0.3), stats.cauchy.logpdf(SIGNED, scale=0.3), rtol=1e-14
    )


def test_numbers_give_numbers() -> None:
    assert isinstance(chances.chi2_sf(3.0, 2), float)
    assert isinstance(chances.f_sf(3.0, 0, 2), float)

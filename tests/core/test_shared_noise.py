"""Noise that the channels of a bench share: its law is found, and intervals hold under it."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.inference.shared_noise import Regression, common_law, fit_under, law_under

_LADDER = np.array([0.0, 2.0, 5.0, 10.0, 20.0, 10.0, 5.0, 2.0, 0.0])
_LOAD = np.tile(_LADDER, 4)
_SESSION = np.repeat(np.arange(4), _LADDER.size)
_TIME = np.asarray(20.0 * np.arange(_LOAD.size), dtype=np.float64)
_DESIGN = np.column_stack([_LOAD - _LOAD.mean(), np.ones(_LOAD.size)])
_MEMORY_S = 120.0


def bench(
    rng: np.random.Generator, slow: float, session: float, channels: int = 6
) -> list[Regression]:
    """Channels that read their load but for white noise of sd 1 and what lasts."""
    apart = np.abs(_TIME[:, None] - _TIME)
    drift = np.linalg.cholesky(np.exp(-apart / _MEMORY_S) + 1e-12 * np.eye(_TIME.size))
    level = np.unique(_LOAD, return_inverse=True)[1]
    rows = []
    for _ in range(channels):
        noise = rng.normal(size=_TIME.size) + slow * (drift @ rng.normal(size=_TIME.size))
        reading = _LOAD - _LOAD.mean() + noise + session * rng.normal(size=4)[_SESSION]
        rows.append(Regression.of(_DESIGN, reading, _LOAD, _SESSION, level, _TIME))
    return rows


def ratios(benches: list[list[Regression]]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Error over stated sd of slope and zero."""
    found = []
    for channels in benches:
        common = common_law(channels)
        for rows in channels:
            fit = fit_under(rows, common, law_under(rows, common))
            zero = np.array([-_LOAD.mean(), 1.0])
            off = fit.coefficients - [1.0, 0.0]
            sd = np.sqrt([fit.covariance[0, 0], zero @ fit.covariance @ zero])
            found.append(np.array([off[0], zero @ off]) / sd)
    return np.array(found)


def test_drift_through_all_sessions_is_found_and_zeros_hold() -> None:
    rng = np.random.default_rng(5)
    benches = [bench(rng, slow=1.4, session=0.0) for _ in range(4)]
    common = common_law([rows for channels in benches for rows in channels])
    assert common.lasting
    *ratio, memory = np.exp(common.law)
    assert 1.0 < ratio[3] < 4.0  # 1.4²
    assert 60.0 < memory < 240.0
    # independent rows would have the zero err by more than twice its sd
    assert np.all(np.sqrt(np.mean(ratios(benches) ** 2, axis=0)) < 1.35)


def test_fresh_noise_is_not_taken_for_lasting() -> None:
    rng = np.random.default_rng(6)
    benches = [bench(rng, slow=0.0, session=0.0) for _ in range(3)]
    assert not any(common_law(channels).lasting for channels in benches)
    rms = np.sqrt(np.mean(ratios(benches) ** 2, axis=0))
    assert np.all((rms > 0.55) & (rms < 1.35))

"""Two transducers in series on a stiff leg."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.pose.series import fit_series, series_words


def test_relative_mounting_and_combination_of_offsets_are_found() -> None:
    rng = np.random.default_rng(1)
    rot = Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix()
    pos = np.array([0.02, -0.01, 0.3])
    load = np.cumsum(rng.normal(size=(4000, 6)), axis=0) * np.array([0.3] * 3 + [0.03] * 3)
    load[:1000] = load[0]
    offset_1, offset_2 = rng.normal(size=6), rng.normal(size=6)
    force = load[:, :3] @ rot.T
    carried = np.hstack([force, load[:, 3:] @ rot.T + np.cross(pos, force)])
    one = load + offset_1 + 0.01 * rng.normal(size=load.shape)
    two = carried + offset_2 + 0.01 * rng.normal(size=load.shape)
    fit = fit_series("hip", "ankle", one, two, quiet_rows=1000, block_rows=50)
    np.testing.assert_allclose(fit.rot_21, rot, atol=1e-3)
    np.testing.assert_allclose(fit.pos_2_m, pos, atol=1e-3)
    turned = rot @ offset_1[:3]
    expected = offset_2 - np.concatenate([turned, rot @ offset_1[3:] + np.cross(pos, turned)])
    np.testing.assert_allclose(fit.combination, expected, atol=0.02)
    assert fit.turn_deg == pytest.approx(np.rad2deg(np.sqrt(0.14)), abs=0.1)
    assert fit.explained > 0.999
    assert fit.force_left_n < 0.05


def test_words_say_what_is_not_seen() -> None:
    rng = np.random.default_rng(2)
    load = rng.normal(size=(500, 6))
    fit = fit_series("hip", "ankle", load, load + 5.0, quiet_rows=100, block_rows=10)
    words = series_words(fit)
    assert "own offset is not seen" in words[0]
    assert "without the body's orientation" in words[1]

"""The robot on its own cells: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.online.belief import nameplate
from footcal_cli.core.online.weighed import weighed_standing, weighed_walking

CHANNELS = tuple(f"cell {i}" for i in range(8))


def test_scales_that_all_moved_alike_say_another_mass() -> None:
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    # cells are right and the robot is stated 7.5 % too heavy: every scale seems 7.5 % too small
    tiny = 1e-8 * np.eye(8)
    found = weighed_walking(belief, np.full(8, 0.075), tiny, 1.0, 5.3 * 1.075)
    assert found.mass_kg == pytest.approx(5.3, abs=1e-3)
    assert found.sd_kg == pytest.approx(5.3 * 0.02 / np.sqrt(8), rel=1e-3)
    assert found.findings()[0].code == "mass_differs"
    scattered = 0.03 * np.array([1, -1, 1, -1, 1, -1, 1, -1])
    assert not weighed_walking(belief, scattered, tiny, 1.0, 5.3).findings()


def test_what_a_walk_hardly_shows_is_weighed_by_its_own_say() -> None:
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    prior = 0.02**2 / 8
    own = 3.0 * prior
    # one measurement of the mean gain, of variance `own`, that says 4 %
    after = 1.0 / (1.0 / prior + 1.0 / own)
    covariance = np.full((8, 8), after)
    found = weighed_walking(belief, np.full(8, 0.04 * after / own), covariance, 1.0, 5.0)
    assert found.mass_kg == pytest.approx(5.0 / 1.04, rel=1e-6)
    assert found.sd_kg == pytest.approx(5.0 / 1.04 * np.sqrt(prior + own), rel=1e-6)


def test_errors_that_repeat_make_a_weight_unsure_and_no_other() -> None:
    """Covariances nine times as large say nothing of what the rows asked for."""
    belief = nameplate(CHANNELS, np.full(8, 1e-5), np.zeros(8), gain_sd=0.02)
    prior = 0.02**2 / 8
    after = 1.0 / (1.0 / prior + 3.0 / prior)
    asked = 0.01
    gain = np.full(8, asked * (1.0 - after / prior))
    found = weighed_walking(belief, gain, np.full((8, 8), 9.0 * after), 9.0, 5.0)
    assert found.mass_kg == pytest.approx(5.0 / (1.0 + asked), rel=1e-9)
    assert found.sd_kg == pytest.approx(5.0 / 1.01 * np.sqrt(prior + 9.0 * prior / 3.0), rel=1e-9)
    assert not found.findings()


def test_standing_weighs_with_all_that_is_known_of_zeros_and_scales() -> None:
    row = np.concatenate([np.full(8, 6.5 * 0.02), np.full(8, 0.3)])
    h = np.tile(row, (3, 1))
    found = weighed_standing(h, np.full(3, -3.9), np.full(3, 0.15), np.eye(16), 55.9, 5.7)
    assert found.mass_kg == pytest.approx(5.7 * (1.0 - 3.9 / 55.9))
    force_sd = np.sqrt(8 * (6.5 * 0.02) ** 2 + 8 * 0.3**2 + 0.15**2 / 3)
    assert found.sd_kg == pytest.approx(5.7 / 55.9 * force_sd)
    assert found.findings()
    assert found.hidden_kg == pytest.approx(4.0 * found.sd_kg)
    assert not weighed_standing(
        h, np.full(3, 0.3), np.full(3, 0.15), np.eye(16), 55.9, 5.7
    ).findings()

"""Pieces of guessing whose mistakes would pass for a calibration."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.core.hang.intake import held_still
from footcal_cli.sniff.attitudes import orientation_in
from footcal_cli.sniff.tokens import number_signs


@pytest.mark.parametrize(
    ("texts", "separator", "signs"),
    [
        (["0,5", "8.388.607"], ";", (",", ".")),
        (["1,000", "8,388,607"], ",", (".", ",")),
        (["0,500", "1,000"], ";", (",", "")),
        (["1.000", "2.000"], ",", (".", "")),
        (["1,234.5", "12.5"], ";", (".", ",")),
        (["0,5 kg", "8388607"], ";", (",", "")),
        (["8 388 607", "0,5"], ";", (",", " ")),
    ],
)
def test_signs_of_numbers(texts: list[str], separator: str, signs: tuple[str, str]) -> None:
    assert number_signs(texts, separator) == signs


@pytest.mark.parametrize(
    ("name", "axis"),
    [
        ("hang_plus_x.csv", "+x"), ("minus_z", "-z"), ("x_up", "-x"), ("ft_y_down", "+y"),
        ("+x", "+x"), ("z-", "-z"), ("neg y", "-y"), ("xylophone", None), ("run_3", None),
    ],
)  # fmt: skip
def test_orientations_in_names(name: str, axis: str | None) -> None:
    assert orientation_in(name) == axis


def test_noise_of_an_attitude_is_averaged_and_a_turn_is_kept() -> None:
    rng = np.random.default_rng(5)
    holds = np.repeat(np.array([[0, 0, -1.0], [0.6, 0, -0.8], [0, 1, 0]]), 200, axis=0)
    found = held_still(9.81 * (holds + rng.normal(0, 1e-3, holds.shape)))
    assert np.unique(found, axis=0).shape[0] <= 6
    assert np.abs(found - holds).max() < 4e-3
    angle = np.linspace(0, np.pi, 1000)
    turning = np.column_stack([np.sin(angle), 0 * angle, -np.cos(angle)])
    assert np.arccos(np.clip((held_still(turning) * turning).sum(axis=1), -1, 1)).max() < 0.011

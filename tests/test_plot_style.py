"""What figures of long logs draw."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import peaks_kept
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    BEFORE,
    CELL_COLOURS,
    MARKERS,
    MOST_POINTS,
    REFERENCE,
    new_figure,
    tidy,
)

SEEN_BY = {
    "all cones": np.eye(3),
    "no red cones": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]
    ),
    "no green cones": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.011820, 0.042940, 0.968881]]
    ),
}  # fmt: skip
"""Linear RGB as seen (Machado, Oliveira and Fernandes 2009, severity 1)."""


@pytest.mark.parametrize("size", [1, 3999, 4001, 100_003])
def test_a_long_series_is_drawn_by_few_points_and_keeps_its_peaks(size: int) -> None:
    values = np.sin(np.arange(size) / 50.0)
    values[size // 3], values[size // 2] = 9.0, -9.0
    values[size // 5] = np.nan if size > 5 else 0.0
    drawn = peaks_kept(values, MOST_POINTS)
    assert drawn.size <= MOST_POINTS
    assert (np.diff(drawn) > 0).all()
    shown = values[drawn]
    assert np.nanmax(shown) == np.nanmax(values)
    assert np.nanmin(shown) == np.nanmin(values)
    if size <= MOST_POINTS:
        assert drawn.size == size


def linear(colour: str) -> FloatArray:
    """Linear RGB, IEC 61966-2-1."""
    c = np.array(to_rgb(colour))
    return np.asarray(np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4))


def lab(rgb: FloatArray) -> FloatArray:
    """CIE 1976 L*a*b* of linear RGB, D65."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x = np.array(to_xyz) @ np.clip(rgb, 0.0, 1.0) / np.array([0.9505, 1.0, 1.089])
    f = np.where(x > 0.008856, np.cbrt(x), 7.787 * x + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("colour", [*CELL_COLOURS, BEFORE, AFTER, REFERENCE, BAD])
def test_every_curve_stands_out_from_white_by_wcag(colour: str) -> None:
    luminance = float(linear(colour) @ [0.2126, 0.7152, 0.0722])
    assert 1.05 / (luminance + 0.05) >= 3.0  # WCAG 2.1, 1.4.11, graphics


@pytest.mark.parametrize("seen", SEEN_BY.values(), ids=SEEN_BY.keys())
def test_cells_differ_by_colour_for_the_colour_blind_and_by_marker(seen: FloatArray) -> None:
    places = [lab(seen @ linear(colour)) for colour in CELL_COLOURS]
    nearest = min(float(np.linalg.norm(a - b)) for a, b in combinations(places, 2))
    assert nearest > 20.0  # Okabe and Ito's eight: 11
    assert len(set(MARKERS)) >= len(CELL_COLOURS)


@pytest.mark.parametrize("values", [(6.5e6, 8.3e6), (-34.0018, -34.0004)])
def test_ticks_need_no_number_above_the_axis(values: tuple[float, float]) -> None:
    figure = new_figure(2.0)
    axes = figure.add_subplot()
    axes.plot(values, values)
    tidy(axes)
    figure.canvas.draw()
    for axis in (axes.xaxis, axes.yaxis):
        assert axis.get_offset_text().get_text() == ""
        shown = [float(t.get_text().replace("\N{MINUS SIGN}", "-")) for t in axis.get_ticklabels()]
        assert len({*shown}) == len(shown)
        assert min(values) - 1e6 < min(shown) < max(shown) < max(values) + 1e6

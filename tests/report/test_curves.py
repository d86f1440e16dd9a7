"""Curves of a figure as the page zooms into them: the numbers drawn, peaks and gaps kept."""

from __future__ import annotations

import json

import numpy as np
from matplotlib.figure import Figure

from footcal_cli.plots.style import new_figure
from footcal_cli.records.results import RunRecord, VerdictRecord
from footcal_cli.report import Picture, Report
from footcal_cli.report.curves import MOST_POINTS, curves_of
from footcal_cli.report.page import render_html
from tests.conftest import drawing


def test_a_curve_keeps_its_numbers_label_and_unit() -> None:
    figure = new_figure(2.0)
    axes = figure.subplots()
    axes.plot([0.0, 1.0, 2.0], [5.0, -7.25, np.nan], label="left_fl")
    axes.axhline(0.0)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("force (N)")
    (panel,) = json.loads(curves_of(figure))
    assert (panel["x"], panel["y"]) == ("time (s)", "force (N)")
    (curve,) = panel["curves"]  # a rule across the panel is no curve
    assert curve["label"] == "left_fl"
    assert curve["x"] == [0.0, 1.0, 2.0]
    assert curve["y"] == [5.0, -7.25, None]


def test_a_long_curve_keeps_its_peak_and_its_gap() -> None:
    y = np.sin(np.arange(200_000) / 50.0)
    y[123_456], y[50_000] = 40.0, np.nan
    figure = new_figure(2.0)
    figure.subplots().plot(np.arange(y.size), y)
    (panel,) = json.loads(curves_of(figure))
    curve = panel["curves"][0]
    assert len(curve["x"]) <= MOST_POINTS
    assert curve["y"][curve["x"].index(123_456)] == 40.0
    assert None in curve["y"]


def _walk() -> Figure:
    figure = new_figure(2.0)
    figure.subplots().plot([0, 1, 2], [0, 1, 4], label="</script><b>left_fl</b>")
    return figure


def test_only_pages_with_curves_carry_the_charts_and_a_label_cannot_end_their_element() -> None:
    verdict = VerdictRecord(level="good", sentence="Fits.")
    run = RunRecord(
        command="check", started="2026-11-24", arguments={}, recipe={}, options={}, inputs={},
        rows={}, seed=0, timings_s={}, verdict=verdict, exit_code=0,
    )  # fmt: skip
    pages = {}
    for zoom in (False, True):
        picture = Picture("walk", _walk, "A walk.", title="A walk", result="It walks.", zoom=zoom)
        report = Report("Test", verdict, pictures=(picture,))
        with drawing():
            pages[zoom] = render_html(report, run, "{}", {"walk": picture.drawn()})
    assert "uPlot" not in pages[False].replace("new uPlot", "").replace("uPlot.join", "")
    assert 'class="curves"' not in pages[False]
    assert "</script><b>" not in pages[True]
    source = pages[True].split('class="curves">')[1].split("</script>")[0]
    assert json.loads(source)[0]["curves"][0]["label"] == "</script><b>left_fl</b>"

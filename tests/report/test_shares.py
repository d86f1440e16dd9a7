"""Shares of an error in words, and the ground of figures on a dark page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import footcal_cli.report
from footcal_cli.sheets.bench import _of_all
from footcal_cli.sheets.diagnosis.words import share_interval, share_text

CSS = Path(footcal_cli.report.__file__).parent / "templates" / "report.css"


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.101, "+10.1 %"), (-0.00001, "+0.0 %"), (-0.345, "−34.5 %"), (-1.0, "−100.0 %"),
     (-1.001, "worse"), (-22972985.69, "worse")],
)  # fmt: skip
def test_a_share_that_no_reader_needs_is_worse(share: float, text: str) -> None:
    assert share_text(share, sign=True) == text


def test_bounds_below_a_doubled_error_are_bounded() -> None:
    assert share_interval(0.27, 0.46, 0) == "[27, 46]"
    assert share_interval(-0.023, 0.034) == "[−2.3, 3.4]"
    assert share_interval(-2.3e7, 0.047) == "[< −100.0, 4.7]"
    assert share_interval(-2.3e7, -1.2e3, 0) == "[< −100, < −100]"


def test_the_dark_ground_of_a_figure_is_not_undone_by_a_later_rule() -> None:
    css = CSS.read_text(encoding="utf-8").partition("@media print")[0]
    grounds = re.findall(r"figure \.frame \{[^}]*background: (#\w+)", css)
    assert grounds == ["#ffffff", "#121212"]  # rules of equal weight: the last one holds


@pytest.mark.parametrize(
    ("some", "whole", "text"),
    [(0, 4, "No channel goes"), (1, 1, "The only channel goes"), (1, 4, "1 of 4 channels goes"),
     (3, 8, "3 of 8 channels go")],
)  # fmt: skip
def test_channels_that_leave_the_band(some: int, whole: int, text: str) -> None:
    assert _of_all(some, whole) == text

"""Findings of one cause on many channels are one line."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.quality import Finding
from footcal_cli.report.causes import one_per_cause
from footcal_cli.sheets.diagnosis.words import where_of


def lost(where: str, rows: int) -> Finding:
    said = f"{rows} of 3200 samples are missing"
    return Finding("lost_samples", "note", where, said, "check the connection")


def test_findings_that_differ_in_channel_and_number_are_one() -> None:
    other = Finding("gaps", "warning", "cells", "2 gaps", "check the link")
    many = [lost("FL.fx", 19), other, lost("FL.fy", 19), lost("FR.fx", 23)]
    one, kept = one_per_cause(many)
    assert one.where == "FL.fx, FL.fy, FR.fx"
    assert one.sentence == "19 … 23 of 3200 samples are missing"
    assert kept == other


def test_two_with_different_numbers_stay_two() -> None:
    assert one_per_cause([lost("a", 3), lost("b", 30)]) == [lost("a", 3), lost("b", 30)]
    (same,) = one_per_cause([lost("a", 3), lost("b", 3)])
    assert same == lost("a, b", 3)


@pytest.mark.parametrize(
    ("members", "where", "said"),
    [
        (("sensor.fx", "sensor.fz"), "each cell of its own", "each axis of its own"),
        (("sensor.fx", "sensor.fz"), "all cells", "all axes"),
        (("left_fl", "left_fr"), "each cell of its own", "each cell of its own"),
    ],
)
def test_a_transducer_has_axes_where_others_have_cells(
    members: tuple[str, ...], where: str, said: str
) -> None:
    signature = cast("Signature", SimpleNamespace(owners=(("all", members),), where=where))
    assert where_of(signature) == said


def test_numbers_with_decimals_and_signs_are_ranges_of_whole_numbers() -> None:
    said = ("7.18 ± 0.42 mm (x −6.8, y −2.7 mm)", "18.93 ± 0.12 mm (x +18.2, y +7.2 mm)",
            "9.08 ± 0.31 mm (x +8.1, y +9.9 mm)")  # fmt: skip
    made = one_per_cause([
        Finding("cell_misplaced", "warning", cell, text, "measure")
        for cell, text in zip("abc", said, strict=True)
    ])  # fmt: skip
    assert [f.sentence for f in made] == [
        "7.18 … 18.93 ± 0.12 … 0.42 mm (x −6.8 … +18.2, y −2.7 … +9.9 mm)"
    ]
    assert made[0].where == "a, b, c"

"""Whether notes say that y points to the right."""

from __future__ import annotations

import pytest

from footcal_cli.sniff.said_axes import points_right


@pytest.mark.parametrize(
    ("line", "above", "right"),
    [
        ("x forward, y left, z up", [], False), ("x forward, y right, z down", [], True),
        ("x nach vorn, y nach rechts", [], True), ("x fremad (tå), y mod venstre", [], False),
        ("x to the toe, +y: to the right", [], True), ("left (x, y) and right (x, y)", [], False),
        ("x vers l'avant, y vers la droite", [], True), ("cells x, y of the right foot", [], False),
        ("y toward medial side", ["Foot plate, left foot"], True),
        ("y toward medial side", ["Foot plate, right foot"], False),
        ("y toward medial side", ["left foot", "right foot"], False),
        ("y lateral", ["right foot"], True), ("y lateral", ["left foot"], False),
        ("y is positive right", [], True), ("x right, y forward", [], False),
        ("y = 35, right cell", [], False),
    ],
)  # fmt: skip
def test_y_to_the_right(line: str, above: list[str], right: bool) -> None:
    assert points_right(line, above) is right

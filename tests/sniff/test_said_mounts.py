"""What notes say of transducers at feet: place, turn, and what hangs below."""

from __future__ import annotations

import numpy as np
import pytest

from footcal_cli.sniff.said_mounts import said_mount

G = 9.8


@pytest.mark.parametrize(
    ("lines", "place_m"),
    [
        (["Sensor centre in sole frame: (-12, 0, 92) mm, both feet."], (-0.012, 0.0, 0.092)),
        (["Mitte des Sensors bei (1,5; 0; 9,2) cm über der Sohle"], (0.015, 0.0, 0.092)),
        (["F/T origin above the sole, m [0.01, 0, 0.09]"], (0.01, 0.0, 0.09)),
        (["Czujnik: (10, 0, 90 mm) nad stopą"], (0.01, 0.0, 0.09)),
        (["left sensor at (1, 2, 3) cm", "right sensor at (1, -2, 3) cm"], (0.01, 0.02, 0.03)),
        (["Sensor at (10, 0, 90) in the sole frame"], None),  # no unit
        (
            ["Sensor frame (x forward, y left, z up): 92 mm above the sole on its z axis"],
            (0.0, 0.0, 0.092),
        ),
        (["Aufnehmer 9,2 cm über der Sohle auf deren z-Achse"], (0.0, 0.0, 0.092)),
        (["Sensor 92 mm above the sole"], None),  # nothing says that it is above the origin
        (["Sensor 12 mm ahead, 92 mm up its z axis"], None),
        (["The CoM starts at (0, 0, 650) mm"], None),
        (["Sensor A at (1, 2, 3) cm", "sensor B at (4, 5, 6) cm"], None),
    ],
)
def test_the_place_of_a_transducer(
    lines: list[str], place_m: tuple[float, float, float] | None
) -> None:
    said = said_mount(lines, "left").place_m
    assert (said is None) == (place_m is None)
    if said is not None and place_m is not None:
        assert np.allclose(said, place_m)


@pytest.mark.parametrize(
    ("line", "parallel"),
    [
        ("Sensor axes parallel to the sole frame.", True),
        ("Sensorachsen parallel zur Sohle", True),
        ("Sensor axes parallel to the sole frame (x forward, y left, z up)", True),
        ("sensors aligned with the foot", True), ("Sensor axes not aligned with the foot", False),
        ("the sensor is turned by 30 deg, z parallel to the sole normal", False),
        ("Robot walks parallel to the wall", False),
    ],
)  # fmt: skip
def test_axes_that_are_parallel(line: str, parallel: bool) -> None:
    assert said_mount([line], "right").parallel is parallel


@pytest.mark.parametrize(
    ("mass", "com_m"),
    [
        ("Mass below the sensor: 1.13 kg each, its centre in sole frame (10, 0, 36) mm",
         (0.022, 0.0, -0.056)),
        ("Below the sensor: 1130 g, CoM in sensor axes (22, 0, -56) mm", (0.022, 0.0, -0.056)),
        ("Unter dem Sensor hängen 1,13 kg", None),
        ("Mass below the sensor: 1.13 kg, its centre at (10, 0, 36) mm", None),  # from where?
    ],
)  # fmt: skip
def test_what_hangs_below(mass: str, com_m: tuple[float, float, float] | None) -> None:
    lines = ["Sensor axes parallel to the sole frame.", f"g = {G}",
             "Sensor centre in sole frame: (-12, 0, 92) mm, both feet", mass]  # fmt: skip
    said = said_mount(lines, "left")
    assert said.weight_n == pytest.approx(1.13 * G)
    assert (said.com_m is None) == (com_m is None)
    if said.com_m is not None and com_m is not None:
        assert np.allclose(said.com_m, com_m)


def test_lines_of_the_recipe_name_their_sentences() -> None:
    place, *others = said_mount(["Sensor at (0, 0, 90) mm over the sole"], "left").lines()
    said = "# likely: 'Sensor at (0, 0, 90) mm over the sole'"
    assert place == f"transducer_position_m = [0.0, 0.0, 0.09]    {said}"
    assert others == []

"""A running log of a foot's cells, and events with a start and an end under any names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.several import parts_of

CELLS = {"toe_lat": (0.12, 0.04), "toe_med": (0.12, -0.04), "heel_lat": (-0.06, 0.03),
         "heel_med": (-0.06, -0.03)}  # fmt: skip
HOLES = {"T1": (0.1, 0.02), "T2": (0.1, -0.02), "M1": (0.05, 0.0), "H1": (-0.04, 0.02),
         "H2": (-0.04, -0.02)}  # fmt: skip


def write(folder: Path, header: str, empty: str) -> list[Path]:
    """A weight of 120 N that lies for 6 s on each hole, four times; a sheet of cells and holes."""
    rng = np.random.default_rng(6)
    places = np.array([*CELLS.values()])
    table = np.vstack([np.ones(4), places.T])
    read, events, clock = [], [], 0.0

    def go(force: np.ndarray, seconds: float) -> None:
        nonlocal clock
        for _ in range(round(10 * seconds)):
            row = force + np.array([1.5, -2.0, 0.7, 0.2]) + rng.normal(0, 0.2, 4)
            read.append(f"{clock:.2f}," + ",".join(f"{v:.3f}" for v in row))
            clock += 0.1

    order = [empty, *HOLES, *reversed(HOLES), *HOLES, *reversed(HOLES), empty]
    for hole in order:
        go(np.zeros(4), 2.0)
        at = HOLES.get(hole)
        put = np.zeros(3) if at is None else 120.0 * np.array([1.0, *at])
        began = clock
        go(np.linalg.lstsq(table, put, rcond=None)[0], 6.0 + rng.uniform(0, 1))
        events.append(f"Plate,{hole},{began:.2f},{clock:.2f}")
    sheet = [f"{name},{x},{y}" for name, (x, y) in {**CELLS, **HOLES}.items()]
    lines = {
        "plate.csv": ["time," + ",".join(f"LC_{c}_vz" for c in CELLS), *read],
        "events.csv": [header, *events], "places.csv": ["label,x,y", *sheet],
    }  # fmt: skip
    for name, text in lines.items():
        (folder / name).write_text("\n".join(text) + "\n", encoding="utf-8")
    return [folder / name for name in lines]


def meant(names: Mapping[str, str]) -> dict[str, float]:
    return {word: float(place) for word, place in names.items()}


@pytest.mark.parametrize(
    ("header", "empty"),
    [
        ("Context,Name,Start (s),End (s)", "empty"),
        ("Bereich,Marke,Beginn [s],Ende [s]", "leer"),
        ("tier,text,tmin,tmax", "empty"),
        ("x,hole,start,stop", "empty"),
    ],
)
@pytest.mark.parametrize("with_sheet", [True, False])
def test_events_are_placements(header: str, empty: str, with_sheet: bool, tmp_path: Path) -> None:
    paths = write(tmp_path, header, empty)[: 3 if with_sheet else 2]
    [part], others = parts_of([guess_file(path) for path in paths])
    assert not others
    assert part.plan.role == "placements"
    [beside] = part.beside
    assert beside.file.path.name == "events.csv"
    if with_sheet:
        found = meant(part.plan.entries["hole_x_m"].names)
        assert found == {empty: 0.0, **{name: at[0] for name, at in HOLES.items()}}
        assert any("toe_lat" in table and "x_m = 0.12" in table for table in part.plan.robot)

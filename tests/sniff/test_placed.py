"""A known weight on holes of a foot, as labs write it: a table of holes beside it, or none."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.several import parts_of
from tests.conftest import Run

CELLS_M = np.array([[0.09, 0.03], [0.09, -0.03], [-0.06, 0.03], [-0.06, -0.03]])
HOLES_M = np.array(
    [[0.08, 0.02], [0.08, -0.02], [0.04, 0.0], [0.0, 0.025], [0.0, -0.025], [-0.05, 0.0]]
)


def shares(hole_m: FloatArray) -> FloatArray:
    """What four cells of a stiff plate carry of a weight on a hole, shape (4,)."""
    x, y = hole_m
    front = (x - CELLS_M[2, 0]) / (CELLS_M[0, 0] - CELLS_M[2, 0])
    left = (y - CELLS_M[1, 1]) / (CELLS_M[0, 1] - CELLS_M[1, 1])
    return np.array(
        [front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left)]
    )


class Bench:
    """Cells with zeros and scales of their own, in counts or volts per newton."""

    def __init__(self, seed: int, per_newton: float, digits: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.per_newton = per_newton * self.rng.uniform(0.95, 1.05, 4)
        self.zero = per_newton * self.rng.uniform(-20, 20, 4)
        self.digits, self.noise = digits, 0.02 * per_newton

    def read(self, load_n: FloatArray) -> list[str]:
        """Readings under loads in N, shape (4,)."""
        noise = self.noise * self.rng.standard_normal(4)
        return [f"{v:.{self.digits}f}" for v in self.zero + self.per_newton * load_n + noise]

    def placed(self, header: str, names: list[str], *, empty: str, kg: tuple[float, ...]) -> str:
        """Three rounds over all holes in random order, each from an empty plate on."""
        lines = [header]
        for turn in (1, 2, 3):
            rows = [(h, m) for h in range(len(HOLES_M)) for m in kg]
            order = [(-1, 0.0), *(rows[i] for i in self.rng.permutation(len(rows)))]
            for h, mass in order:
                load = shares(HOLES_M[h]) * mass * 9.80665 if h >= 0 else np.zeros(4)
                place = [names[h] if h >= 0 else empty] if names else []
                place = place or [f"{1e3 * v:g}" for v in HOLES_M[h]]
                lines.append(",".join([str(turn), *place, f"{mass:g}", *self.read(load)]))
        return "\n".join(lines) + "\n"

    def alone(
        self, header: str, names: list[str], kg: tuple[float, ...] = (0, 2, 5, 9, 5, 2, 0)
    ) -> str:
        """Each cell by itself, up and down, twice."""
        lines = [header]
        for cell, name in enumerate(names):
            for rep in (1, 2):
                for mass in (0, 2, 5, 9, 5, 2, 0):
                    load = np.zeros(4)
                    load[cell] = mass * 9.80665
                    lines.append(f"{name},{rep},{mass:g},{self.read(load)[cell]}")
        return "\n".join(lines) + "\n"


def written(folder: Path, **texts: str) -> list[FileGuess]:
    for name, text in texts.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return [guess_file(folder / f"{name}.csv") for name in texts]


def placements(parts: list[Part]) -> Part:
    return next(part for part in parts if part.plan.role == "placements")


def table(head: str, names: list[str], per_m: float) -> str:
    rows = (f"{n},{per_m * x:g},{per_m * y:g}" for n, (x, y) in zip(names, HOLES_M, strict=True))
    return "\n".join([head, *rows]) + "\n"


_CM = "bohrung;x [cm];y [cm]"
HEADS = [
    ("round,hole,mass_kg,FL,FR,RL,RR", "hole,x_mm,y_mm", 1e3, "A1 A2 B C1 C2 D", "-"),
    ("pass,pos,load_kg,z1_kg,z2_kg,z3_kg,z4_kg", "pos,x_m,y_m", 1.0, "p1 p2 p3 p4 p5 p6", "none"),
    ("lauf,bohrung,masse_kg,adc_vl,adc_vr,adc_hl,adc_hr", _CM, 100.0, "a b c d e f", "leer"),
    ("serie,punto,peso_kg,U1_mV,U2_mV,U3_mV,U4_mV", "punto,x,y", 1e3, "1 2 3 4 5 6", "0"),
    ("serie,spot_no,kg,U1_mV,U2_mV,U3_mV,U4_mV", "no,X (mm),Y (mm)", 1e3, "1 2 3 4 5 6", "0"),
    ("run,where,mass_g,s1,s2,s3,s4", "name,x,y", 1e3, "heel toe arch ball in out", "nothing"),
]


@pytest.mark.parametrize(("header", "head", "per_m", "words", "empty"), HEADS)
def test_a_sheet_places_the_holes(
    tmp_path: Path, header: str, head: str, per_m: float, words: str, empty: str
) -> None:
    names = words.split()
    counts = "mV" not in header and "_kg,z" not in header
    bench = Bench(1, 21_000.0 if counts else 0.1, 0 if counts else 4)
    sheet = table(head, names, per_m)
    sheet = sheet.replace(",", ";") if ";" in head else sheet
    made = bench.placed(header, names, empty=empty, kg=(5.0, 10.0))
    parts, others = parts_of(written(tmp_path, placed=made, holes=sheet))
    assert others == []
    entries = placements(parts).plan.entries
    for axis, place in zip("xy", HOLES_M.T, strict=True):
        entry = entries[f"hole_{axis}_m"]
        unit = {"m": 1.0, "cm": 0.01, "mm": 1e-3}[entry.unit or ""]
        found = {word: float(v) * unit for word, v in entry.names.items()}
        assert found[empty] == 0.0
        assert [found[name] for name in names] == pytest.approx(place.tolist())
    assert sum(name.endswith("_counts") for name in entries) == 4
    assert entries["repeat"].column is not None
    assert entries["repeat"].column.column == header.split(",")[0]


def test_holes_that_no_sheet_places_are_asked_for(tmp_path: Path) -> None:
    bench = Bench(2, 0.05, 4)
    names = [str(i) for i in range(1, 7)]
    made = bench.placed("series,hole_no,kg,S1_mV,S2_mV,S3_mV,S4_mV", names, empty="0", kg=(8.0,))
    alone = bench.alone("cell,rep,mass_kg,mV", ["S1", "S2", "S3", "S4"])
    parts, _ = parts_of(written(tmp_path, placements=made, single_cells=alone))
    plan = placements(parts).plan
    assert dict(plan.entries["hole_x_m"].names) == {"0": "0", **dict.fromkeys(names, "?")}
    assert any("holes" in blank.why for blank in plan.blanks)
    weighed = next(part.plan for part in parts if part.plan.role == "weights")
    assert weighed.channels == plan.channels == tuple(f"foot_s{i}" for i in range(1, 5))
    assert weighed.entries["counts"].unit == plan.entries["s1_counts"].unit == "mV"


def test_init_and_offline_fit_find_the_cop(tmp_path: Path, run: Run) -> None:
    bench = Bench(3, 20_000.0, 0)
    names = ["A1", "A2", "B", "C1", "C2", "D"]
    made = bench.placed("round,hole,mass_kg,FL,FR,RL,RR", names, empty="-", kg=(5.0, 10.0))
    alone = bench.alone("cell,rep,mass_kg,counts", ["FL", "FR", "RL", "RR"])
    written(tmp_path, placed=made, bench=alone, holes=table("hole,x_mm,y_mm", names, 1e3))
    cells = ["cell,x_mm,y_mm"] + [
        f"{n},{1e3 * x:g},{1e3 * y:g}"
        for n, (x, y) in zip(("FL", "FR", "RL", "RR"), CELLS_M, strict=True)
    ]
    (tmp_path / "cells.csv").write_text("\n".join(cells) + "\n", encoding="utf-8")
    logs = [tmp_path / f"{name}.csv" for name in ("placed", "bench", "holes", "cells")]
    answer = run("init", *logs, "-o", tmp_path / "a.toml")
    assert answer.exit_code == 0, answer.err
    assert "TO FILL IN" not in answer.out
    done = run("offline-fit", "--recipe", tmp_path / "a.toml", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.err
    said = done.out.replace("\n", " ")
    assert "No correction of the CoP helps on unseen placements: 0.0" in said


def test_holes_by_x_and_y_in_the_same_table(tmp_path: Path) -> None:
    bench = Bench(4, 20_000.0, 0)
    header = "round,x_mm,y_mm,mass_kg,c1,c2,c3,c4"
    made = bench.placed(header, [], empty="", kg=(5.0,)).replace(",-50,0,0,", ",0,0,0,")
    plan = placements(parts_of(written(tmp_path, placed=made))[0]).plan
    assert plan.entries["hole_x_m"].unit == "mm"
    assert not any("holes" in blank.why for blank in plan.blanks)


def test_weights_on_one_cell_at_a_time_are_no_placements(tmp_path: Path) -> None:
    bench = Bench(5, 20_000.0, 0)
    lines = ["run,on,mass_kg,FL,FR,RL,RR"]
    for run in (1, 2):
        for cell, name in enumerate(("FL", "FR", "RL", "RR")):
            for mass in (0, 2, 5, 10, 5):
                load = np.zeros(4)
                load[cell] = mass * 9.80665
                lines.append(",".join([str(run), name, str(mass), *bench.read(load)]))
    parts, _ = parts_of(written(tmp_path, weights="\n".join(lines) + "\n"))
    assert [part.plan.role for part in parts] == ["weights"]


@pytest.mark.parametrize("form", ["%d-%b-%Y %H:%M:%S", "%d %b %Y %H:%M", "%d/%b/%Y %I:%M:%S %p"])
def test_a_stamp_with_the_name_of_a_month_is_a_time_and_no_hole(tmp_path: Path, form: str) -> None:
    names = [str(i) for i in range(1, 7)]
    made = Bench(3, 21_000.0, 0).placed("Trial,Hole,kg,A,B,C,D", names, empty="0", kg=(9.0,))
    head, *rows = made.splitlines()
    at = [datetime(2025, 2, 6, 14) + timedelta(seconds=25 * i) for i in range(len(rows))]
    stamped = [f"{t.strftime(form)},{row}" for t, row in zip(at, rows, strict=True)]
    made = "\n".join([f"Timestamp,{head}", *stamped]) + "\n"
    sheet = table("hole,x_mm,y_mm", names, 1e3)
    parts, others = parts_of(written(tmp_path, placed=made, holes=sheet))
    entries = placements(parts).plan.entries
    read = [entries[name].column for name in ("time_s", "placement")]
    assert not others
    assert [c and (c.column, c.format) for c in read] == [("Timestamp", form), ("Hole", None)]

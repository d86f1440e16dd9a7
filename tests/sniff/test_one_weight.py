"""One weight on the holes of a plate that no column weighs: a table, a file each, a running log."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.several import parts_of
from footcal_cli.sniff.shared_weight import share_one_weight
from tests.conftest import Run
from tests.sniff.test_placed import CELLS_M, HOLES_M, Bench, shares, table

MASS_KG = 6.0
LOAD_N = MASS_KG * 9.80665
HOLES = ("A1", "A2", "B1", "B2", "C1", "C2")


def visits(rng: np.random.Generator, turns: int = 4) -> list[tuple[int, int]]:
    """Rounds over all holes in random order: round, hole."""
    return [(turn, int(h)) for turn in range(1, turns + 1) for h in rng.permutation(len(HOLES_M))]


def placed(bench: Bench, head: str, sep: str = ",", first: bool = True) -> str:
    """A row for each placement: a number, the round, the hole, the cells; no weight."""
    lines = [head]
    for number, (turn, h) in enumerate(visits(bench.rng)):
        said = [str(number + 1)] * first + [str(turn), HOLES[h]]
        lines.append(sep.join([*said, *bench.read(shares(HOLES_M[h]) * LOAD_N)]))
    return "\n".join(lines) + "\n"


def write(folder: Path, **texts: str) -> list[Path]:
    paths = [folder / f"{name}.csv" for name in texts]
    for path, text in zip(paths, texts.values(), strict=True):
        path.write_text(text, encoding="utf-8")
    return paths


def parts(paths: list[Path]) -> dict[str, Part]:
    found, others = parts_of([guess_file(path) for path in paths])
    assert others == []
    return {part.plan.role: part for part in found}


def places_of(part: Part) -> dict[str, tuple[float, ...]]:
    """Name of a hole, or of a file -> its place in mm."""
    x, y = (part.plan.entries[f"hole_{axis}_m"].names for axis in "xy")
    return {name: (float(x[name]), float(y[name])) for name in x}


MM = {name: pytest.approx(tuple(1e3 * place)) for name, place in zip(HOLES, HOLES_M, strict=True)}
HEADS = [
    ("n,vuelta,agujero,cuentas_1,cuentas_2,cuentas_3,cuentas_4", "agujero,x_mm,y_mm"),
    ("trial,rep,hole_id,F_FL_N,F_FR_N,F_RL_N,F_RR_N", "hole_id,x_mm,y_mm"),
    ("nr,Durchgang,Bohrung,Z1,Z2,Z3,Z4", "Bohrung,x_mm,y_mm"),
    ("prova,giro,foro,c1_kg,c2_kg,c3_kg,c4_kg", "foro,x_mm,y_mm"),
    ("n,round,where,adc_a,adc_b,adc_c,adc_d", "name,x_mm,y_mm"),
]


@pytest.mark.parametrize(("head", "sheet"), HEADS)
def test_cells_that_share_a_weight_tell_placements(tmp_path: Path, head: str, sheet: str) -> None:
    forces = "_N" in head or "_kg" in head
    bench = Bench(11, 0.1 if "_kg" in head else 1.0 if forces else 2_000.0, 3 if forces else 0)
    paths = write(tmp_path, placed=placed(bench, head), holes=table(sheet, list(HOLES), 1e3))
    plan = parts(paths)["placements"].plan
    assert places_of(parts(paths)["placements"]) == MM
    assert plan.entries["load_n"].value == "?"
    assert any("weighs" in blank.why for blank in plan.blanks)
    assert sum(name.endswith("_counts") for name in plan.entries) == 4
    repeat = plan.entries["repeat"].column
    assert repeat is not None
    assert repeat.column == head.split(",")[1]


def test_a_missing_reading_makes_no_dead_cell(tmp_path: Path) -> None:
    text = placed(Bench(12, 1.0, 3), HEADS[1][0]).splitlines()
    fields = text[9].split(",")
    text[9] = ",".join([*fields[:4], "", *fields[5:]])
    paths = write(tmp_path, placed="\n".join(text), holes=table(HEADS[1][1], list(HOLES), 1e3))
    part = parts(paths)["placements"]
    assert part.plan.warnings == ("F_FR_N: 1 of 24 rows have no reading and are left out",)


def test_an_empty_plate_between_the_placements_is_no_load(tmp_path: Path) -> None:
    bench = Bench(13, 2_000.0, 0)
    lines = placed(bench, "round,hole,c1,c2,c3,c4", first=False).splitlines()
    for turn in (1, 2, 3):
        lines.append(",".join([str(turn), "leer", *bench.read(np.zeros(4))]))
    paths = write(tmp_path, placed="\n".join(lines), holes=table("hole,x_mm,y_mm", [*HOLES], 1e3))
    plan = parts(paths)["placements"].plan
    assert dict(plan.entries["load_n"].names) == {"leer": "0", **dict.fromkeys(HOLES, "?")}


def test_cells_that_carry_no_common_weight_are_none() -> None:
    rng = np.random.default_rng(14)
    places = np.repeat(np.arange(6), 4)
    each = rng.normal(0, 50, (6, 4))[places] + rng.normal(0, 0.1, (24, 4))
    assert not share_one_weight(list(each.T), places)
    whole = np.array([shares(HOLES_M[i]) for i in places]) * LOAD_N
    whole = whole * rng.uniform(0.7, 1.4, 4) + rng.normal(0, 0.1, (24, 4))
    assert share_one_weight(list(whole.T), places)
    assert not share_one_weight(list(whole.T), rng.permutation(places))  # no place explains it


class Mounted(Bench):
    """Cells whose zeros the plate moves by newtons once it is screwed to them."""

    def alone_then_mounted(self, header: str, names: list[str]) -> str:
        text = self.alone(header, names)
        self.zero = self.zero + self.per_newton * np.array([1.5, -1.2, 1.0, -1.4])
        return text


def cop_error_mm(out: str) -> float:
    """CoP error on unseen placements without a correction, by the verdict of `offline-fit`."""
    found = re.search(r"(?:unseen placements|left out of the fit): ([\d.]+)", " ".join(out.split()))
    assert found is not None, out
    return float(found[1])


def filled(text: str, cells: list[str]) -> str:
    """A recipe with the weight and the places of the cells that it asks for."""
    text = text.replace('value = "?"', f"value = {MASS_KG}")
    text = re.sub(r"^# (\[robot\.feet\.)", r"\1", text, flags=re.MULTILINE)
    for name, (x, y) in zip(cells, CELLS_M, strict=True):
        text = text.replace(f"# {name} = {{ x_m = , y_m =  }}",
                            f"{name} = {{ x_m = {x}, y_m = {y} }}")  # fmt: skip
    return text


def test_readings_of_the_empty_plate_are_its_zeros(tmp_path: Path, run: Run) -> None:
    bench = Mounted(15, 2_000.0, 0)
    names = [f"cuentas_{i}" for i in range(1, 5)]
    alone = bench.alone_then_mounted("celda,serie,masa_kg,cuentas", ["1", "2", "3", "4"])
    empty = "\n".join([",".join(["despues_de_vuelta", *names]), *(
        ",".join([str(i), *bench.read(np.zeros(4))]) for i in range(6)
    )])  # fmt: skip
    holes = table(HEADS[0][1], list(HOLES), 1e3)
    paths = write(tmp_path, pesas=alone, vacio=empty, puestas=placed(bench, HEADS[0][0]),
                  agujeros=holes)  # fmt: skip
    answer = run("init", *paths, "-o", tmp_path / "a.toml")
    assert answer.exit_code == 0, answer.err
    recipe = tmp_path / "b.toml"
    text = filled((tmp_path / "a.toml").read_text(encoding="utf-8"), names)
    assert 'zeros = ["vacio.csv"]' in text
    recipe.write_text(text, encoding="utf-8")
    done = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.err
    said = done.out.replace("\n", " ")
    assert cop_error_mm(done.out) < 0.1
    assert "the zeros of 4 cells are those of this log" in said
    known = pd.read_json(tmp_path / "out" / "parameters.json", typ="series")["parameters"]
    for i, zero in enumerate(bench.zero):
        scale, bias = (known[f"foot_cuentas_{i + 1}.{n}"]["value"] for n in ("scale", "bias"))
        assert scale * zero + bias == pytest.approx(0.0, abs=0.05)
    found = run("diagnose", "--recipe", recipe, "--experiment", "placements", "--parameters",
                tmp_path / "out" / "parameters.json", "--out", tmp_path / "d")  # fmt: skip
    assert "No unmodelled effect found" in found.out.replace("\n", " ")
    recipe.write_text(re.sub("(?m)^zeros = .*$", "", text), encoding="utf-8")
    without = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "without")
    assert without.exit_code != 0 or cop_error_mm(without.out) > 0.3


def filmed(bench: Bench, hole: int, head: str, sep: str, frames: int = 40) -> str:
    load = shares(HOLES_M[hole]) * LOAD_N
    return "\n".join([head, *(sep.join([str(i), *bench.read(load)]) for i in range(frames))]) + "\n"


ABOVE = [
    ("# prova;{n}\n# foro;{hole}\n# giro;{turn}\n# unita;kg\ncampione;c1;c2;c3;c4", ";", "001"),
    ("% trial: {n}\n% hole: {hole}\n% round: {turn}\nsample,s1,s2,s3,s4", ",", "001"),
    ("Messung {n}\nBohrung = {hole}\nDurchgang = {turn}\nNr\tZ1\tZ2\tZ3\tZ4", "\t", "001"),
    ("sample,s1,s2,s3,s4", ",", "001_B2"),
]


@pytest.mark.parametrize(("head", "sep", "name"), ABOVE)
def test_a_file_for_each_placement(tmp_path: Path, head: str, sep: str, name: str) -> None:
    bench, paths, truth = Bench(16, 0.1, 3), [], {}
    for n, (turn, h) in enumerate(visits(bench.rng, 3)):
        word = f"{n:03d}" + f"_{HOLES[h]}" * ("_" in name)
        text = filmed(bench, h, head.format(n=n, hole=HOLES[h], turn=turn), sep)
        paths += write(tmp_path, **{f"prova_{word}": text})
        truth[word] = MM[HOLES[h]]
    paths += write(tmp_path, fori=table("foro,x_mm,y_mm", list(HOLES), 1e3))
    part = parts(paths)["placements"]
    assert len(part.paths) == len(truth)
    assert places_of(part) == truth
    assert ("repeat" in part.plan.entries) == ("turn" in head)
    units = {e.unit for n, e in part.plan.entries.items() if n.endswith("_counts")}
    assert units == ({"kg"} if "unita" in head else {None})


def test_frames_of_a_visit_are_one_placement(tmp_path: Path, run: Run) -> None:
    bench, paths = Bench(17, 0.1, 3), []
    alone = bench.alone("cella,giro,massa_kg,lettura", ["c1", "c2", "c3", "c4"])
    for n, (turn, h) in enumerate(visits(bench.rng, 3)):
        text = filmed(bench, h, ABOVE[0][0].format(n=n, hole=HOLES[h], turn=turn), ";", 60)
        paths += write(tmp_path, **{f"prova_{n:03d}": text.replace("# unita;kg\n", "")})
    paths += write(tmp_path, fori=table("foro,x_mm,y_mm", list(HOLES), 1e3), pesi=alone)
    answer = run("init", *paths, "-o", tmp_path / "a.toml")
    assert answer.exit_code == 0, answer.err
    recipe = tmp_path / "b.toml"
    recipe.write_text(
        filled((tmp_path / "a.toml").read_text(encoding="utf-8"), ["c1", "c2", "c3", "c4"]),
        encoding="utf-8",
    )
    done = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.err
    assert cop_error_mm(done.out) < 0.1
    rows = pd.read_parquet(tmp_path / "out" / "placements.parquet")
    assert len(rows) == 18


def running(folder: Path, bench: Bench, *, named: bool, ends: bool) -> list[Path]:
    """Six cells' readings at 10 Hz, the weight carried between holes; and when it lay where."""
    at, rows, index = 0.0, [], []

    def reads(load: FloatArray, seconds: float) -> None:
        nonlocal at
        for _ in range(round(10 * seconds)):
            rows.append([f"{at:.2f}", *bench.read(load)])
            at += 0.1

    for number, (_, h) in enumerate(visits(bench.rng, 3)):
        reads(np.zeros(4), 4.0)
        began = at
        reads(shares(HOLES_M[h]) * LOAD_N, 6.0)
        place = [HOLES[h]] if named else [str(number + 1), *(f"{v:g}" for v in HOLES_M[h])]
        index.append([*place, f"{began + 0.3:.2f}", *[f"{at - 0.3:.2f}"] * ends])
    log = "\n".join(map(",".join, [["t_s", "adc_1", "adc_2", "adc_3", "adc_4"], *rows]))
    head = (["hole"] if named else ["no", "x_m", "y_m"]) + ["t_start_s"] + ["t_stop_s"] * ends
    return write(folder, stream=log, index="\n".join(map(",".join, [head, *index])))


@pytest.mark.parametrize("named", [True, False])
def test_a_running_log_and_when_the_weight_lay_where(tmp_path: Path, run: Run, named: bool) -> None:
    bench = Bench(18, 2_000.0, 0)
    bench.per_newton, bench.zero = np.full(4, 2_000.0), np.zeros(4)  # as its maker says
    paths = running(tmp_path, bench, named=named, ends=True)
    paths += write(tmp_path, holes=table("hole,x_mm,y_mm", list(HOLES), 1e3)) * named
    answer = run("init", *paths, "-o", tmp_path / "a.toml")
    assert answer.exit_code == 0, answer.err
    text = (tmp_path / "a.toml").read_text(encoding="utf-8")
    text = text.replace("# [robot.nameplate]", "[robot.nameplate]")
    text = text.replace("# scale_n_per_count = 1.0 ", "scale_n_per_count = 5e-4 ")
    recipe = tmp_path / "b.toml"
    recipe.write_text(filled(text, [f"adc_{i}" for i in range(1, 5)]), encoding="utf-8")
    done = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.err
    assert cop_error_mm(done.out) < 0.1
    found = run("diagnose", "--recipe", recipe, "--experiment", "placements", "--parameters",
                tmp_path / "out" / "parameters.json", "--out", tmp_path / "d")  # fmt: skip
    assert "No unmodelled effect found" in found.out.replace("\n", " ")

"""Rounds, names of discs, indexes of files and counters of frames are no loads and no cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.rounds import is_a_round
from footcal_cli.sniff.several import parts_of
from tests.sniff.test_placed import CELLS_M, HOLES_M, Bench, shares, table

G = 9.80665
HOLES = ["F1", "F2", "F3", "F4", "F5", "F6"]
LADDER = (0, 2, 5, 8, 5, 2, 0)


def parts(*paths: Path) -> dict[str, Part]:
    found, others = parts_of([guess_file(path) for path in paths])
    assert others == []
    return {part.plan.role: part for part in found}


def write(path: Path, lines: list[str], sep: str = ",") -> Path:
    path.write_text("\n".join(lines).replace(",", sep) + "\n", encoding="utf-8")
    return path


def columns_of(part: Part) -> dict[str, str]:
    entries = part.plan.entries
    return {n: e.column.column for n, e in entries.items() if e.column is not None}


@pytest.mark.parametrize("turn", ["volta", "kierros", "varv", "kai", "gang_nr", "zzz"])
def test_placements_of_several_rounds_with_an_empty_plate_between(
    tmp_path: Path, turn: str
) -> None:
    """A weight goes over all holes in each round; stamped readings of the empty plate are zeros."""
    bench, ms = Bench(3, 4000.0, 0), 1_733_000_000_000
    put, empty = [f"inst_ms,furo,{turn},c1,c2,c3,c4"], ["inst_ms,c1,c2,c3,c4"]
    for number in (1, 2, 3, 4):
        for hole in bench.rng.permutation(len(HOLES)):
            ms += 51_000 + int(bench.rng.integers(0, 9000))
            read = bench.read(shares(HOLES_M[hole]) * 20 * G)
            put.append(",".join([str(ms), HOLES[hole], str(number), *read]))
        ms += 50_000
        empty.append(",".join([str(ms), *bench.read(np.zeros(len(CELLS_M)))]))
    holes = tmp_path / "furos.csv"
    holes.write_text(table("furo,x_mm,y_mm", HOLES, 1000.0), encoding="utf-8")
    made = parts(
        write(tmp_path / "colocacoes.csv", put), write(tmp_path / "vazio.csv", empty), holes
    )
    assert made.keys() == {"placements", "zeros"}
    found = columns_of(made["placements"])
    assert (found["placement"], found["repeat"], found["hole_x_m"]) == ("furo", turn, "furo")
    assert made["placements"].plan.entries["hole_x_m"].names["F1"] == "80"


@pytest.mark.parametrize(
    ("turn", "put", "read"),
    [
        ("varv", "lastetikett_kg", "visning_kg"), ("omgång", "etik_kg", "utslag_kg"),
        ("xyz", "etik_kg", "utslag_kg"),
        pytest.param("varv", "etik_kg", "utslag_kg", marks=pytest.mark.slow),
        pytest.param("omgång", "lastetikett_kg", "visning_kg", marks=pytest.mark.slow),
        pytest.param("xyz", "lastetikett_kg", "visning_kg", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_stream_of_three_cells_in_turn_that_read_kilograms(
    tmp_path: Path, turn: str, put: str, read: str
) -> None:
    rng, lines, ms = np.random.default_rng(5), [f"tid_ms,givare,{turn},{put},{read}"], 0
    for cell, (zero, scale) in {"a": (0.1, 1.002), "b": (-0.2, 0.998)}.items():
        for number in (1, 2):
            for kg in LADDER:
                for _ in range(100):
                    ms += int(rng.integers(38, 43))
                    shown = zero + scale * kg + rng.normal(0, 0.01)
                    lines.append(f"{1_700_000_000_000 + ms},kanal_{cell},{number},{kg},{shown:.3f}")
    found = columns_of(parts(write(tmp_path / "prov.csv", lines))["weights"])
    wanted = {"channel": "givare", "repeat": turn, "load_n": put, "counts": read}
    assert {name: found[name] for name in wanted} == wanted


def test_loads_that_count_up_are_no_rounds() -> None:
    """Readings of a load stay where they are while it does; in a round they pass all they pass."""
    rng = np.random.default_rng(1)
    load = np.repeat([1.0, 2.0, 3.0, 4.0], 10)

    def noise() -> FloatArray:
        return rng.normal(0, 0.1, load.size)

    assert not is_a_round(load, [7 * load + noise(), 3 + 2 * load + noise()])
    one_by_one = [np.where(np.arange(load.size) % 4 == c, load, 0.0) + noise() for c in range(4)]
    assert not is_a_round(load, one_by_one)
    assert is_a_round(load, [np.tile(np.arange(10.0), 4) + noise()])
    assert not is_a_round(2 * load, [np.tile(np.arange(10.0), 4)])


@pytest.mark.parametrize("head", ["disc,label_kg", "piece,mass_g", "disco,kg"])
@pytest.mark.parametrize("empty", ["none", "-", "empty"])
def test_loads_named_by_discs_win_over_a_row_for_each_label(
    tmp_path: Path, head: str, empty: str
) -> None:
    """Each set of discs comes three times, as names of feet do; a disc may be called E."""
    rng = np.random.default_rng(2)
    kg = {"A": 0.5, "B": 1.0, "C": 2.0, "D": 2.0, "E": 5.0}
    sets = [empty, "A", "B", "A+B", "C", "D", "C+D", "E", "E+B", "E+C", "E+C+D", "E+C+D+B+A"]
    lines, number = ["step,repeat,discs,c1_mV_per_V,c2_mV_per_V,c3_mV_per_V,clock"], 0
    for repeat in (1, 2, 3):
        for i in rng.permutation(len(sets)) if repeat == 2 else range(len(sets)):
            total = sum(kg.get(name, 0.0) for name in sets[i].split("+"))
            read = 0.01 * np.array([1, -2, 3]) + 0.08 * total + rng.normal(0, 1e-4, 3)
            number += 1
            lines.append(",".join([str(number), str(repeat), sets[i], *(f"{v:.6f}" for v in read),
                                   f"13:{number:02d}:{7 * repeat:02d}"]))  # fmt: skip
    per = 1000.0 if head.endswith("_g") else 1.0
    sheet = write(tmp_path / "discs.csv", [head, *(f"{n},{per * v:g}" for n, v in kg.items())])
    (part,) = parts(write(tmp_path / "steps.tsv", lines, "\t"), sheet).values()
    entry = part.plan.entries["load_n"]
    assert (part.plan.role, len(part.plan.wide)) == ("weights", 3)
    assert entry.column is not None
    assert (entry.column.column, entry.unit) == ("discs", "g" if per > 1 else "kg")
    assert float(entry.names["E+C+D+B+A"]) == pytest.approx(per * 10.5)
    assert float(entry.names[empty]) == 0.0


@pytest.mark.parametrize(("file", "cell", "run"), [("archivo", "celda", "serie"),
                                                   ("fil", "givare", "varv"),
                                                   ("file", "what", "session")])  # fmt: skip
def test_an_index_of_files_says_cell_and_round_and_frames_are_no_seconds(
    tmp_path: Path, file: str, cell: str, run: str
) -> None:
    rng = np.random.default_rng(4)
    index, paths = [f"{file},{cell},{run}"], list[Path]()
    for name, zero in {"DI": 800.0, "DD": -500.0, "TI": 50.0}.items():
        for number in (1, 2):
            frame, lines = 1000, ["cuadro,cuentas,carga_kg"]
            for kg in LADDER:
                for _ in range(40):
                    frame += 1 + int(rng.random() < 0.01)
                    read = zero + 10_000 * kg + rng.normal(0, 60)
                    lines.append(f"{frame},{read:.0f},{kg:.1f}")
            paths.append(write(tmp_path / f"ensayo_{name}_{number}.csv", lines))
            index.append(f"{paths[-1].name},{name},{number}")
    (part,) = parts(*paths, write(tmp_path / "indice.csv", index)).values()
    plan = part.plan
    assert (plan.role, set(plan.channels)) == ("weights", {"DI", "DD", "TI"})
    assert plan.entries["channel"].names["DI_2"] == "DI"
    turn = plan.entries["session" if run == "session" else "repeat"]
    assert turn.names["TI_2"] == "2"
    assert plan.entries["time_s"].unit == "?"
    assert any("frames" in blank.why for blank in plan.blanks)

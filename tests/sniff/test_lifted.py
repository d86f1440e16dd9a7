"""Stands as labs log them: soles on the floor, cells by letters, stances in a row, zeros."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of

MOTION = ("com_x_mm", "com_y_mm", "com_z_mm", "L_x_mm", "L_y_mm", "L_yaw_deg", "R_x_mm",
          "R_y_mm", "R_yaw_deg")  # fmt: skip


def stand(path: Path, cells: tuple[str, ...], *, again: bool, seed: int = 1) -> Path:
    """Six stances of 4 s at 50 Hz, feet put elsewhere between them; millimetres and degrees."""
    rng = np.random.default_rng(seed)
    lines = [",".join(["stand", "t", *cells, *MOTION])]
    for k in range(6):
        feet = np.array([0.0, 100.0, 2.0, 0.0, -100.0, -2.0]) + rng.uniform(-40, 40, 6)
        read = rng.uniform(0.5, 2.0, len(cells))
        for i in range(200):
            t = 0.02 * i + (0.0 if again else 4.0 * k)
            row = [*(read + rng.normal(0, 0.003, len(cells))), *rng.normal((5, 0, 480), 0.3),
                   *(feet + rng.normal(0, 0.1, 6))]  # fmt: skip
            lines.append(",".join([str(k + 1), f"{t:.3f}", *(f"{v:.4f}" for v in row)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def lifted(path: Path, cells: tuple[str, ...], rows: int = 3) -> Path:
    rng = np.random.default_rng(2)
    lines = [",".join(f"{v:.4f}" for v in rng.normal(0.1, 0.01, len(cells))) for _ in range(rows)]
    path.write_text("\n".join([",".join(cells), *lines]) + "\n", encoding="utf-8")
    return path


def bench(path: Path, cells: tuple[str, ...], reading: str = "mV") -> Path:
    lines = [f"{c},{rep},{m},{0.1 + 0.3 * m:.4f}" for c in cells for rep in (1, 2)
             for m in (0, 1, 2, 5, 2, 1, 0)]  # fmt: skip
    path.write_text("\n".join([f"cell,rep,mass_kg,{reading}", *lines]) + "\n", encoding="utf-8")
    return path


def by_role(parts: list[Part]) -> dict[str, LogPlan]:
    return {part.plan.role: part.plan for part in parts}


LETTERS = ("LA", "LB", "LC", "RA", "RB", "RC")


@pytest.mark.parametrize("before", ["U_", "V", "adc_"])
def test_cells_by_a_letter_for_the_foot_and_one_for_the_cell(tmp_path: Path, before: str) -> None:
    cells = tuple(f"{before}{end}" if before != "V" else end for end in LETTERS)
    logs = [stand(tmp_path / "stand.csv", cells, again=False), bench(tmp_path / "b.csv", LETTERS),
            lifted(tmp_path / "hanging.csv", cells)]  # fmt: skip
    parts, others = parts_of([guess_file(log) for log in logs])
    plans = by_role(parts)
    names = tuple(f"{side}_{cell}" for side in ("left", "right") for cell in "abc")
    assert others == []
    assert set(plans) == {"weights", "cells", "zeros"}
    assert plans["weights"].channels == plans["cells"].channels == names
    units = {plans[role].entries["left_b_counts"].unit for role in ("cells", "zeros")}
    assert units == {plans["weights"].entries["counts"].unit} == {"mV"}


def test_soles_on_the_floor_have_no_height(tmp_path: Path) -> None:
    parts, _ = parts_of([guess_file(stand(tmp_path / "a.csv", LETTERS, again=False))])
    plan = parts[0].plan
    assert plan.command == "static-init"
    for foot in ("left", "right"):
        height = plan.entries[f"{foot}_foot_z_m"]
        assert (height.value, height.sure) == ("0.0", "guess")


def test_stances_whose_clock_begins_again(tmp_path: Path) -> None:
    parts, _ = parts_of([guess_file(stand(tmp_path / "a.csv", LETTERS, again=True))])
    plan = parts[0].plan
    assert (plan.command, plan.rate_hz) == ("static-init", 50.0)
    assert "time_s" not in plan.entries
    assert any("begin again" in warning for warning in plan.warnings)


@pytest.mark.parametrize("name", ["in_the_air.csv", "zero_lifted.csv", "kran.csv", "rows.csv"])
def test_readings_without_stamps_are_zeros_beside_a_stand(tmp_path: Path, name: str) -> None:
    cells = tuple(f"{side}{i}_kgf" for side in "LR" for i in range(3))
    logs = [stand(tmp_path / "pose.csv", cells, again=False), lifted(tmp_path / name, cells),
            bench(tmp_path / "cells.csv", tuple(c[:2] for c in cells), "display_kgf")]  # fmt: skip
    parts, others = parts_of([guess_file(log) for log in logs])
    plans = by_role(parts)
    assert others == []
    assert set(plans) == {"weights", "cells", "zeros"}
    names = tuple(f"{side}_{i}" for side in ("left", "right") for i in range(3))
    assert plans["weights"].channels == plans["cells"].channels == names


def test_two_stands_are_no_zeros(tmp_path: Path) -> None:
    logs = [stand(tmp_path / f"stand_{k}.csv", LETTERS, again=False, seed=k) for k in (1, 2)]
    parts, _ = parts_of([guess_file(log) for log in logs])
    assert {part.plan.role for part in parts} == {"cells"}


@pytest.mark.parametrize(
    ("columns", "of_bench"),
    [("/{side}_foot/cell{k}/force/z", "{side}_foot/cell{k}"), ("toe{k}_{s}_cnt", "toe{k}_{s}")],
)
def test_cells_of_a_bench_whose_names_stand_within_those_of_a_stand(
    tmp_path: Path, columns: str, of_bench: str
) -> None:
    feet = [{"side": side, "s": side[0], "k": str(k)} for side in ("left", "right")
            for k in (1, 2, 3)]  # fmt: skip
    cells = tuple(columns.format(**own) for own in feet)
    logs = [
        stand(tmp_path / "stand.csv", cells, again=False),
        bench(tmp_path / "b.csv", tuple(of_bench.format(**own) for own in feet), "counts"),
    ]
    plans = by_role(parts_of([guess_file(log) for log in logs])[0])
    assert plans["weights"].channels == plans["cells"].channels


TOPICS = tuple(f"/{foot}_foot/load_cells.data[{i}]" for foot in ("left", "right") for i in range(3))


@pytest.mark.parametrize("stamped", [False, True])
@pytest.mark.parametrize("names", [TOPICS, tuple(f"{f}_{i}" for f in ("left", "right")
                                                 for i in range(3))])  # fmt: skip
def test_cells_that_read_next_to_nothing_are_zeros(
    tmp_path: Path, names: tuple[str, ...], *, stamped: bool
) -> None:
    logs = [stand(tmp_path / "stand.csv", TOPICS, again=False)]
    rng = np.random.default_rng(4)
    rows = [f"{0.1 * i:.1f}," * stamped + ",".join(f"{v:.4f}" for v in rng.normal(0, 0.005, 6))
            for i in range(40 if stamped else 2)]  # fmt: skip
    head = "t," * stamped + ",".join(names)
    (tmp_path / "quiet.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    lines = [f"{foot},{i},{run},{m},{9.81 * m:.2f}" for foot in ("left", "right") for i in range(3)
             for run in (1, 2) for m in (0, 5, 10, 20, 10, 5, 0)]  # fmt: skip
    bench_log = tmp_path / "bench.csv"
    head = "foot,cell_index,run,mass_kg,output_N"
    bench_log.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    logs += [tmp_path / "quiet.csv", bench_log]
    found = by_role(parts_of([guess_file(path) for path in logs])[0])
    assert {*found} == {"cells", "zeros", "weights"}
    cells = {*found["cells"].channels}
    assert len(cells) == 6
    assert cells == {*found["weights"].channels}
    assert {n for n in found["zeros"].entries if n != "time_s"} == {f"{c}_counts" for c in cells}
    assert not any("cell_index" in said for said in found["weights"].warnings)
    assert not any("newtons a count" in blank.why for blank in found["cells"].blanks)


def test_a_file_of_no_weight_is_one_of_the_weights(tmp_path: Path) -> None:
    logs = []
    for kg in (0, 10, 20, 40):
        rng = np.random.default_rng(kg)
        rows = [f"{0.01 * i:.2f},{4 + 9.5 * kg + rng.normal(0, 0.3):.3f},{rng.normal(0, 0.1):.3f},"
                f"{rng.normal(0, 0.1):.3f}" for i in range(100)]  # fmt: skip
        logs.append(tmp_path / f"plate_{kg}kg.csv")
        logs[-1].write_text("\n".join(["Time,Fz,Mx,My", *rows]) + "\n", encoding="utf-8")
    (part,) = parts_of([guess_file(path) for path in logs])[0]
    assert part.plan.role == "weights"
    assert len(part.paths) == 4

"""What stands in another file, in other rows or under numbers: joined, held, told apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.recipe.filespecs import JoinSpec
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.several import parts_of
from footcal_cli.tables.logfiles import raw_columns
from footcal_cli.tables.reading import ForeignColumn, Join, Layout, Pivot, Reading
from footcal_cli.tables.sources import source_columns

TIMES = {"time_s": ForeignColumn("time_s", "s")}


def test_what_a_protocol_says_holds_until_its_next_row_but_not_at_its_stamps(
    tmp_path: Path,
) -> None:
    log, sheet = tmp_path / "log.csv", tmp_path / "sheet.csv"
    log.write_text("time_s,raw\n" + "".join(f"{t},{10 * t}\n" for t in range(10)))
    sheet.write_text("time_s,cell,kg\n1,a,2\n5,b,3\n")
    join = Join(sheet, Reading(TIMES), how="previous", tolerance_s=4.0, apart_s=1.5)
    places = {
        "load_n": ForeignColumn("sheet.kg", only_where={"sheet.cell": "a"}),
        "counts": ForeignColumn("raw"),
    }
    found = source_columns(log, Reading(TIMES, joins=(join,)), places, frozenset())
    # 0 is before the first stamp, 4 to 6 are close to the second; on b nothing lies on a
    load = found["load_n"].values.astype(float)
    np.testing.assert_array_equal(load, [np.nan] * 3 + [2, np.nan, np.nan, np.nan, 0, 0, 0])
    np.testing.assert_array_equal(found["load_n"].empty, np.isnan(load))


def test_a_label_that_is_held_says_the_same_until_its_next_row(tmp_path: Path) -> None:
    log = tmp_path / "events.csv"
    log.write_text("at,name,v\n0,load,5\n1,raw,10\n2,raw,11\n2.5,load,7\n3,raw,12\n9,raw,13\n")
    layout = Layout(pivot=Pivot(("name",), ("raw", "load"), "at", ("load",)))
    found = raw_columns(log, ["raw.v", "load.v"], (), layout)
    np.testing.assert_array_equal(found["raw.v"].values, [10, 11, 12, 13])
    np.testing.assert_array_equal(found["load.v"].values, [5, 5, 7, 7])


def test_a_header_that_stands_there_again_is_no_row_next_to_comments(tmp_path: Path) -> None:
    log = tmp_path / "query.csv"
    log.write_text("#group\nload,raw\n0,10\n1,20\n\n#group\nload,raw\n2,30\n")
    found = raw_columns(log, ["load", "raw"], (), Layout(comment="#"))
    np.testing.assert_array_equal(found["raw"].values, [10, 20, 30])


def test_a_protocol_whose_holds_are_never_still_is_not_joined(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0, 60, 0.2)
    raw = np.round(1000 * np.sin(t / 3) + rng.normal(0, 3, t.size))  # nothing is put down
    rows = [f"{a:.1f},{b:.0f}" for a, b in zip(t, raw, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,raw", *rows]) + "\n")
    noted = [f"{k},{m}" for k, m in zip((1, 11, 21, 22, 41), (0, 1, 2, 5, 0), strict=True)]
    (tmp_path / "sheet.csv").write_text("\n".join(["time_s,load_kg", *noted]) + "\n")
    parts, _ = parts_of([guess_file(tmp_path / name) for name in ("log.csv", "sheet.csv")])
    assert not any(b.how == "previous" for part in parts for b in part.beside)


@pytest.mark.parametrize(("late_s", "offset_s"), [(3600.0, -3600.0), (10.0, None)])
def test_a_clock_of_another_zone_is_known_and_one_that_is_wrong_asked_for(
    tmp_path: Path, late_s: float, offset_s: float | None
) -> None:
    rng, loads = np.random.default_rng(4), (0, 500, 1000, 0)
    lines, noted, t = ["time_s,A,B"], ["time_s,cell,load_g"], 0.0
    for on in range(2):
        for load in loads:
            noted.append(f"{t + late_s:g},{'AB'[on]},{load}")
            for _ in range(50):
                read = 1000 + rng.normal(0, 3, 2) + load * (np.arange(2) == on)
                lines.append(f"{t:.1f},{read[0]:.0f},{read[1]:.0f}")
                t += 0.2
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "sheet.csv").write_text("\n".join(noted) + "\n")
    (part,), _ = parts_of([guess_file(tmp_path / name) for name in ("log.csv", "sheet.csv")])
    assert [b.offset_s for b in part.beside] == ([] if offset_s is None else [offset_s])
    asked = [b.why for b in part.plan.blanks if "sheet.csv" in b.why]
    assert len(asked) == (offset_s is None)
    assert all("correct its stamps" in why for why in asked)


@pytest.mark.parametrize("name", ["CoM_{}", "com({})", "CoM[{}]"])
def test_three_numbers_of_a_motion_are_no_cells(tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(5)
    axes = (1, 2, 3)
    head = ["t", *(f"{s}foot_{i}" for s in "LR" for i in range(1, 5)),
            *(name.format(i) for i in axes), *(f"dd{name.format(i)}" for i in axes),
            *(f"p{s}_{i}" for s in "LR" for i in axes)]  # fmt: skip
    n = 40
    cells = np.round(rng.uniform(200, 800, (n, 8)))
    table = np.column_stack([np.arange(n) / 100, cells, rng.normal(0, 0.1, (n, 12))])
    rows = [",".join(f"{v:.6g}" for v in row) for row in table]
    (tmp_path / "walk.csv").write_text("\n".join([",".join(head), *rows]) + "\n")
    plan = plan_of(guess_file(tmp_path / "walk.csv"))
    assert plan is not None
    assert plan.channels == tuple(f"{s}_{i}" for s in ("left", "right") for i in range(1, 5))
    body = {name for name in plan.entries if "counts" not in name}
    assert body >= {"com_z_m", "com_acc_x_mps2", "left_foot_y_m", "right_foot_x_m"}


def test_numbers_of_stances_are_no_load_and_no_cell(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    rows = [f"{0.1 * i:.1f},{1 + i // 20}," + ",".join(f"{v:.0f}" for v in 8e6 + 40
            * rng.normal(0, 1, 4)) for i in range(100)]  # fmt: skip
    for word in ("Posture", "stance"):
        (tmp_path / "stand.csv").write_text(f"time_s,{word},L1,L2,R1,R2\n" + "\n".join(rows))
        plan = plan_of(guess_file(tmp_path / "stand.csv"))
        assert plan is not None
        assert (plan.command, len(plan.channels)) == ("static-init", 4)


def test_rows_close_to_a_stamp_cannot_be_negative() -> None:
    with pytest.raises(ValueError, match="greater than or equal to 0"):
        JoinSpec(file="sheet.csv", apart_s=-1.0)

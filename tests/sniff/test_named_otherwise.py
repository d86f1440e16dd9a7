"""Stands whose CoM, feet and cells are called otherwise, in lengths without a unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.sniff.several import parts_of

CELLS = ("Li1", "Li2", "Li3", "Re1", "Re2", "Re3")


def stand(path: Path, cells: tuple[str, ...], motion: list[str], per_m: float = 1.0) -> LogPlan:
    """Six stances of 4 s at 25 Hz: com x y z, then x y z yaw of the left and of the right foot."""
    rng = np.random.default_rng(7)
    lines = [",".join(["t", *cells, *motion])]
    for k in range(6):
        com = np.array([0.02, 0.0, 0.6]) + rng.uniform(-0.02, 0.02, 3)
        feet = np.array([0.0, 0.1, 0.0, 0.03, 0.0, -0.1, 0.0, -0.04])
        feet += rng.uniform(-0.04, 0.04, 8) * (1, 1, 0, 1, 1, 1, 0, 1)
        read = rng.uniform(2.0, 9.0, len(cells))
        for i in range(100):
            place = np.array([*com, *feet]) + rng.normal(0, 2e-4, 11)
            place[[0, 1, 2, 3, 4, 5, 7, 8, 9]] *= per_m
            values = [*(read + rng.normal(0, 0.01, len(cells))), *place]
            stamp = f"{4.0 * k + 0.04 * i:.3f}"
            lines.append(
                ",".join([stamp, *(f"{v:.5f}" for v in values[: len(cells) + len(motion)])])
            )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    parts, _ = parts_of([guess_file(path)])
    return parts[0].plan


def named(com: str, left: str, right: str, yaw: str) -> list[str]:
    own = [f"{foot}_{a}" for foot in (left, right) for a in ("x", "y", "z", yaw)]
    return [*(f"{com}_{a}" for a in "xyz"), *own]


COMS, FEET = ("SP", "cdg", "cg", "massenmitte"), (("FL", "FR"), ("LF", "RF"), ("links", "rechts"))


@pytest.mark.parametrize(
    ("com", "left", "right"),
    [
        pytest.param(com, *feet, marks=[] if FEET[i % 3] == feet else [pytest.mark.slow])
        for i, com in enumerate(COMS) for feet in FEET
    ],
)  # fmt: skip
def test_the_com_of_a_stand_lies_above_two_feet(
    tmp_path: Path, com: str, left: str, right: str
) -> None:
    plan = stand(tmp_path / "s.csv", CELLS, named(com, left, right, "yaw"))
    found = {n: e.column.column for n, e in plan.entries.items() if e.column is not None}
    assert plan.command == "static-init"
    for axis in "xyz":
        assert found[f"com_{axis}_m"] == f"{com}_{axis}"
        assert found[f"left_foot_{axis}_m"] == f"{left}_{axis}"
        assert found[f"right_foot_{axis}_m"] == f"{right}_{axis}"
    assert found["left_foot_yaw_rad"] == f"{left}_yaw"


@pytest.mark.parametrize(("per_m", "unit"), [(1e3, "mm"), (100.0, "cm"), (1.0, "m")])
def test_lengths_without_a_unit_by_the_height_of_the_com(
    tmp_path: Path, per_m: float, unit: str
) -> None:
    plan = stand(tmp_path / "s.csv", CELLS, named("com", "left", "right", "yaw"), per_m)
    units = {e.unit or "m" for n, e in plan.entries.items() if n.endswith(("_x_m", "_z_m"))}
    assert units == {unit}


@pytest.mark.parametrize("before", ["mV_", "", "u_"])
def test_inner_and_outer_cells_behind_a_letter_for_the_foot(tmp_path: Path, before: str) -> None:
    cells = tuple(f"{before}{s}{c}" for s in "LR" for c in ("fi", "fo", "hi", "ho"))
    plan = stand(tmp_path / "s.csv", cells, named("com", "soleL", "soleR", "yaw"))
    assert plan.channels == tuple(
        f"{side}_{c}" for side in ("left", "right") for c in ("fi", "fo", "hi", "ho")
    )
    assert plan.command == "static-init"


def test_a_pose_with_w_and_z_alone_is_one_of_a_level_foot(tmp_path: Path) -> None:
    motion = [f"com_{a}" for a in "xyz"]
    motion += [f"sole{s}_{a}" for s in "LR" for a in ("px", "py", "pz", "qz")]
    log = tmp_path / "s.csv"
    stand(log, CELLS, motion)
    rows = log.read_text(encoding="utf-8").splitlines()
    head = f"{rows[0]},soleL_qw,soleR_qw"
    log.write_text("\n".join([head, *(f"{r},0.9993,0.9992" for r in rows[1:])]), encoding="utf-8")
    entries = parts_of([guess_file(log)])[0][0].plan.entries
    for foot in ("left", "right"):
        assert entries[f"{foot}_foot_x_m"].column is not None
        assert {entries[f"{foot}_foot_q{a}"].value for a in "xy"} == {"0.0"}
        assert entries[f"{foot}_foot_qw"].column is not None

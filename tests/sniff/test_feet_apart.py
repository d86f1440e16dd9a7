"""Walks and stands whose feet, frames, poses or zeros stand in files and columns of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.recipe_text import recipe_text
from footcal_cli.sniff.several import parts_of
from tests.sniff.test_walks import HZ, Walk, _bench, _columns, _parts, _written, _xyz

STANCES, ROWS = 4, 60


def _body(walk: Walk, names: tuple[str, str], clock: str) -> dict[str, FloatArray]:
    """CoM, its acceleration, the rate of angular momentum and poses, in a stranger's words."""
    body = {clock: walk.t, **_xyz("baryc_", walk.com), **_xyz("baryc_b_", walk.acc)}
    body |= _xyz("kagaku_", walk.rate)
    for i, name in enumerate(names):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        body |= _xyz(f"{name}_", walk.feet[:, i])
        body |= {f"{name}_q{a}": four[:, j] for j, a in enumerate("xyzw")}
    return body


@pytest.mark.parametrize("sides", [("hidari", "migi"), ("gauche", "droite"), ("L", "R")])
def test_two_feet_in_files_of_columns_called_after_them(
    tmp_path: Path, sides: tuple[str, str]
) -> None:
    walk = Walk()
    paths = []
    for i, side in enumerate(sides):
        rows = slice(0, walk.t.size - 7 * i)  # of two recorders one ends first
        cells = {f"{side}_{k + 1}": walk.counts(i, k)[rows] for k in range(3)}
        stamped = {"t_s": (walk.t + 0.0004 * i)[rows], **cells}
        paths.append(_written(tmp_path / f"foot_{side}.csv", stamped))
    body = _written(tmp_path / "body.csv", _body(walk, sides, "t_s"))
    bench = {f"{side}_{k + 1}": "mean" for side in sides for k in range(3)}
    found = _parts([*paths, _bench(tmp_path / "bench.csv", bench), body])
    cells_part = found["cells"]
    assert [beside.by for beside in cells_part.beside] == ["time"]
    expected = {f"{foot}_{k}" for foot in ("left", "right") for k in (1, 2, 3)}
    assert set(cells_part.plan.channels) == expected == set(found["weights"].plan.channels)
    assert found["body"].plan.command == "online-replay"
    motion = _columns(found["body"].plan)
    assert motion["com_acc_y_mps2"] == "baryc_b_y"
    assert motion["right_foot_qw"] == f"{sides[1]}_qw"


@pytest.mark.parametrize("every", [1, 2])
def test_frames_are_counted_at_the_rate_by_which_they_last_as_long_as_the_body(
    tmp_path: Path, every: int
) -> None:
    walk = Walk()
    cells = {
        f"{side}{place}_kg": walk.cells[::every, i, k] / 9.81
        for i, side in enumerate("LR") for k, place in enumerate(("FL", "FR", "HL", "HR"))
    }  # fmt: skip
    frames = np.arange(len(next(iter(cells.values())))).astype(float)
    log = _written(tmp_path / "LoadCells.csv", {"frame": frames, **cells}, 3)
    masses = np.array([0.0, 5, 10, 20, 10, 5])
    noise = np.random.default_rng(2).normal(0, 0.01, (len(cells), masses.size))
    shown = {n: 0.2 + 1.05 * masses + own for n, own in zip(cells, noise, strict=True)}
    shown = {"weight_kg": masses, **shown}
    body = {"time": walk.t, **_xyz("center_of_mass_", walk.com), **_xyz("com_acc_", walk.acc)}
    for i, side in enumerate("lr"):
        body |= _xyz(f"sole_{side}_t", walk.feet[:, i])
        body |= _xyz(f"sole_{side}_r", np.degrees(walk.rpy[:, i]))
    motion = tmp_path / "motion.sto"
    head = f"motion\nversion=1\nnRows={walk.t.size}\nnColumns={len(body)}\ninDegrees=yes\n"
    table = pd.DataFrame(body).round(5).to_csv(sep="\t", index=False)
    motion.write_text(f"{head}endheader\n{table}")
    found = _parts([log, _written(tmp_path / "bench.csv", shown, 3), motion])
    clock = found["cells"].plan.entries["time_s"]
    assert clock.column is not None
    assert clock.column.column == "frame"
    assert clock.factor == pytest.approx(every / HZ)
    assert found["cells"].plan.entries["left_fl_counts"].unit == "kg"
    assert found["body"].plan.entries["left_foot_yaw_rad"].unit == "deg"
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)


@pytest.mark.parametrize(("size", "unit"), [(1.0, None), (1e3, "mm/s^2"), (1 / 9.80665, "g0")])
def test_the_unit_of_an_acceleration_next_to_a_com_in_millimetres(
    tmp_path: Path, size: float, unit: str | None
) -> None:
    walk = Walk()
    cells = {f"{s}{k}": walk.counts(i, k) for i, s in enumerate("LR") for k in range(4)}
    body = {"t_s": walk.t, **_xyz("cdm_", 1e3 * walk.com), **_xyz("cdm_acc_", size * walk.acc)}
    for i, side in enumerate(("gauche", "droite")):
        body |= _xyz(f"semelle_{side}_", 1e3 * walk.feet[:, i])
    found = _parts([_written(tmp_path / "a.csv", {"t_s": walk.t, **cells}),
                    _written(tmp_path / "b.csv", body)])  # fmt: skip
    assert found["body"].plan.entries["com_acc_x_mps2"].unit == unit
    assert found["body"].plan.entries["com_z_m"].unit == "mm"


@pytest.mark.parametrize("unit", ["digit", "Skt", "u.a."])
def test_brackets_that_all_cells_end_with_are_no_part_of_their_names(
    tmp_path: Path, unit: str
) -> None:
    walk = Walk()
    cells = {
        f"{side}{k + 1} [{unit}]": walk.counts(i, k)
        for i, side in enumerate("LR") for k in range(4)
    }  # fmt: skip
    body = _written(tmp_path / "state.csv", _body(walk, ("Sole L", "Sole R"), "t_s"))
    log = _written(tmp_path / "cells.csv", {"t_s": walk.t, **cells})
    bench = _bench(tmp_path / "bench.csv", {n.split()[0]: "Anzeige" for n in cells})
    found = _parts([log, bench, body])
    expected = {f"{foot}_{k + 1}" for foot in ("left", "right") for k in range(4)}
    assert set(found["cells"].plan.channels) == expected == set(found["weights"].plan.channels)


def _stands(to: Path, *, apart: bool) -> tuple[list[Path], pd.DataFrame, dict[str, float]]:
    """Four stances below each other or in a file each, the poses of their feet, zeros of cells."""
    rng = np.random.default_rng(8)
    zeros = {f"{side}_{k + 1}": float(rng.integers(-400, 700))
             for side in ("hidari", "migi") for k in range(3)}  # fmt: skip
    frames, poses = list[pd.DataFrame](), []
    for n in range(1, STANCES + 1):
        share = 0.5 + 0.1 * np.sin(n + np.arange(ROWS) / 9)
        log: dict[str, FloatArray] = {} if apart else {"stance": np.full(ROWS, float(n))}
        for i, cell in enumerate(zeros):
            force = 60.0 * (share if i < 3 else 1 - share) + rng.normal(0, 0.2, ROWS)
            log[cell] = np.round(zeros[cell] + 20 * force)
        log |= _xyz("COM_", np.array([10.0, 3 * n, 850]) + rng.normal(0, 0.2, (ROWS, 3)))
        frames.append(pd.DataFrame(log))
        for foot, side in (("hidari", 1), ("migi", -1)):
            called = f"shisei_{n}" if apart else str(n)
            x, y, yaw = rng.normal(0, 9), 110 * side + rng.normal(0, 4), rng.normal(0, 0.05)
            poses.append((called, foot, round(x, 1), round(y, 1), 0.2, round(yaw, 4)))
    paths = []
    for n, frame in enumerate(frames if apart else [pd.concat(frames)], 1):
        paths.append(to / (f"shisei_{n}.csv" if apart else "stand.csv"))
        frame.to_csv(paths[-1], index=False)
    names = ["stance", "ashi", "X_mm", "Y_mm", "Z_mm", "yaw_rad"]
    return paths, pd.DataFrame(poses, columns=names), zeros


def _all(paths: list[Path]) -> dict[str, Part]:
    parts, others = parts_of([guess_file(path) for path in paths])
    assert not others
    return {part.plan.role: part for part in parts}


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("apart", [False, True])
def test_poses_of_the_feet_by_stance_and_zeros_by_cell(
    tmp_path: Path, apart: bool, wide: bool
) -> None:
    logs, poses, zeros = _stands(tmp_path, apart=apart)
    sheet = poses
    if wide:
        sheet = poses.pivot_table(index="stance", columns="ashi").swaplevel(axis=1)
        sheet.columns = ["_".join(column) for column in sheet.columns.to_flat_index()]
        sheet = sheet.reset_index()
    sheet.to_csv(tmp_path / "poses.csv", index=False)
    listed = [(cell, when, z) for when in ("mae", "ato") for cell, z in zeros.items()]
    unloaded = pd.DataFrame(listed, columns=["sensa", "toki", "yomi"])
    unloaded.to_csv(tmp_path / "ashi_zero.csv", index=False)
    bench = _bench(tmp_path / "bench.csv", dict.fromkeys(zeros, "yomi"))
    found = _all([bench, *logs, tmp_path / "poses.csv", tmp_path / "ashi_zero.csv"])
    assert set(found) == {"weights", "cells", "zeros"}
    plan = found["cells"].plan
    assert plan.command == "static-init"
    assert "stand: m" not in " ".join(blank.why for blank in plan.blanks)
    own = poses[poses["ashi"] == "migi"]
    yaw = plan.entries["right_foot_yaw_rad"]
    assert [float(yaw.names[str(n + 1)]) for n in range(STANCES)] == own["yaw_rad"].tolist()
    assert plan.entries["left_foot_x_m"].unit == "mm"
    assert (yaw.file_name is None) is not apart
    read = _columns(found["zeros"].plan)
    assert read["right_3_counts"] == "migi_3.yomi"
    text = recipe_text(list(found.values()), tmp_path / "recipe.toml", "")
    assert 'zeros = ["ashi_zero.csv"]' in text
    assert 'by = ["sensa"]' in text

"""Walks as recorders write them: a file for each topic, cells in arrays, one bench for all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.notes import with_notes
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.recipe_text import recipe_text
from footcal_cli.sniff.several import parts_of
from tests.sniff.test_walks import Walk, _columns, _parts, _xyz


def _topic(path: Path, at_s: FloatArray, columns: dict[str, FloatArray], texts: str = "") -> Path:
    """A message in each row, stamps from 1970 in seconds and nanoseconds."""
    at_ns = np.round((1760004321.0 + at_s) * 1e3).astype(np.int64) * 1_000_000
    stamps = {"header.stamp.sec": at_ns // 10**9, "header.stamp.nanosec": at_ns % 10**9}
    frame = {"header.frame_id": texts} if texts else {}
    pd.DataFrame({**stamps, **frame, **columns}).round(6).to_csv(path, index=False)
    return path


def _topics(folder: Path, walk: Walk, state: str, pose: str, cells: str) -> list[Path]:
    com = _xyz("com.position.", walk.com) | _xyz("com.velocity.", walk.vel)
    com |= _xyz("com.acceleration.", walk.acc) | _xyz("angular_momentum_rate.", walk.rate)
    paths = [_topic(folder / f"{state}.csv", walk.t, com, "odom")]
    for i, foot in enumerate(("left", "right")):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        placed = _xyz("pose.position.", walk.feet[:, i])
        placed |= {f"pose.orientation.{a}": four[:, j] for j, a in enumerate("xyzw")}
        rows = slice(i, None)  # of two topics one begins later
        placed = {name: values[rows] for name, values in placed.items()}
        path = folder / f"{foot}_foot__{pose}.csv"
        paths.append(_topic(path, walk.t[rows] + 0.001, placed, "odom"))
        arrays = {f"force[{k}]": walk.cells[rows, i, k] for k in range(3)}
        path = folder / f"{foot}_foot__{cells}.csv"
        paths.append(_topic(path, walk.t[rows] + 0.002, arrays))
    return paths


@pytest.mark.parametrize("names", [
    ("centroidal_estimator__state", "sole_pose", "load_cells"), ("a", "tf", "pads"),
])  # fmt: skip
def test_a_file_for_each_topic(tmp_path: Path, names: tuple[str, str, str]) -> None:
    walk = Walk()
    cells = [f"{foot}_foot/{c}" for foot in ("left", "right")
             for c in ("toe", "heel_left", "heel_right")]  # fmt: skip
    rng = np.random.default_rng(4)
    rows = [{"run": 1, "cell": cell, "mass_kg": kg, "reading": 1.0 + 9.7 * kg + rng.normal(0, 0.1)}
            for cell in cells for kg in (0, 2, 5, 10, 5, 2, 0)]  # fmt: skip
    bench = tmp_path / "calibration_bench.csv"
    pd.DataFrame(rows).round(2).to_csv(bench, index=False)
    found = _parts([bench, *_topics(tmp_path, walk, *names)])
    body, sensors, weights = (found[role] for role in ("body", "cells", "weights"))
    motion = _columns(body.plan)
    assert motion["com_acc_z_mps2"] == "com.acceleration.z"
    assert motion["angmom_rate_x_nm"] == "angular_momentum_rate.x"
    assert motion["left_foot_x_m"] == f"left_foot__{names[1]}.pose.position.x"
    assert motion["right_foot_qw"] == f"right_foot__{names[1]}.pose.orientation.w"
    assert [beside.by for beside in body.beside] == ["time", "time"]
    assert body.plan.command == "online-replay"
    assert _columns(sensors.plan)["right_2_counts"] == f"right_foot__{names[2]}.force[2]"
    expected = {f"{foot}_{k}" for foot in ("left", "right") for k in range(3)}
    assert set(sensors.plan.channels) == expected == set(weights.plan.channels)
    assert weights.plan.entries["channel"].names["right_foot/toe"] == "right_0"
    assert any("in their order" in said for said in weights.plan.warnings)
    text = recipe_text(list(found.values()), tmp_path / "r.toml", "--recipe r.toml")
    assert f'file = "right_foot__{names[1]}.csv", by = "time"' in text


def test_a_vector_of_a_force_is_no_row_of_cells(tmp_path: Path) -> None:
    """Along the floor a force changes sign, or is small beside what presses."""
    walk = Walk()
    force = 40.0 * (walk.acc + np.array([0.0, 0.0, 9.81])) * (1 - walk.air[:, [0]])
    path = _topic(tmp_path / "left.csv", walk.t, {f"force[{k}]": force[:, k] for k in range(3)})
    axes = {c.name.axis for c in numbered(guess_file(path)).of("force")}
    assert axes == {"fx", "fy", "fz"}


def test_without_a_com_nothing_is_joined(tmp_path: Path) -> None:
    walk = Walk()
    paths = _topics(tmp_path, walk, "state", "pose", "cells")[1:]
    parts, others = parts_of([guess_file(path) for path in paths])
    assert all(not part.plan.file.joined for part in parts)
    assert all(not file.joined for file in others)


TO_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""From x forward, y left, z up to x forward, y up, z right."""


def _sto(path: Path, columns: dict[str, FloatArray]) -> Path:
    """A table as OpenSim stores it."""
    rows = pd.DataFrame(columns).round(6).to_csv(None, sep="\t", index=False)
    head = f"{path.stem}\nversion=1\nnRows={len(columns['time'])}\ninDegrees=no\nendheader\n"
    path.write_text(head + rows)
    return path


def test_y_up_with_matrices_of_the_soles_in_a_file_of_their_own(tmp_path: Path) -> None:
    walk = Walk()
    com = {"time": walk.t, **_xyz("com_p", walk.com @ TO_Y_UP.T)}
    com |= _xyz("com_v", walk.vel @ TO_Y_UP.T) | _xyz("com_a", walk.acc @ TO_Y_UP.T)
    com |= _xyz("hdot_", walk.rate @ TO_Y_UP.T)
    feet, felt = {"time": walk.t}, {"time": walk.t}
    share = (1 - walk.air) / np.maximum((1 - walk.air).sum(axis=1), 1)[:, None]
    for i, foot in enumerate("lr"):
        sole = Rotation.from_euler("xyz", walk.rpy[:, i]).as_matrix()
        turned = TO_Y_UP @ sole @ TO_Y_UP.T
        feet |= _xyz(f"sole_{foot}_p", walk.feet[:, i] @ TO_Y_UP.T)
        feet |= {f"sole_{foot}_r{j + 1}{k + 1}": turned[:, j, k] for j, k in np.ndindex(3, 3)}
        whole = 40.0 * (walk.acc + np.array([0.0, 0.0, 9.81])) * share[:, [i]] @ TO_Y_UP.T
        read = np.einsum("nji,nj->ni", turned, whole)
        felt |= _xyz(f"ankle_{foot}_f", read) | _xyz(f"ankle_{foot}_m", 0.01 * read)
    found = _parts([
        _sto(tmp_path / "t_ankle.sto", felt), _sto(tmp_path / "t_com.sto", com),
        _sto(tmp_path / "t_feet.sto", feet),
    ])  # fmt: skip
    body, sensors = found["body"], found["cells"]
    motion = _columns(body.plan)
    assert motion["right_foot_r32"] == "t_feet.sole_r_r32"
    assert motion["com_acc_y_mps2"] == "com_ay"
    assert any(line.startswith('world_up = "+y"') for line in body.plan.robot)
    assert body.plan.command == sensors.plan.command == "online-replay"
    assert sensors.plan.mounting == ""
    assert {e.factor for e in sensors.plan.entries.values()} == {None}


@pytest.mark.parametrize("frame", ["rpy", "xyzw", "wxyz"])
def test_numbers_alone_in_a_file_for_each_quantity(tmp_path: Path, frame: str) -> None:
    """``walk.com``, ``walk.lsole`` …: names end by what is in them, and no column has one."""
    walk = Walk()
    files = {"com": np.hstack([walk.com, walk.vel, walk.acc]), "amom": walk.rate}
    for i, foot in enumerate("lr"):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        turned = {"rpy": walk.rpy[:, i], "xyzw": four, "wxyz": four[:, [3, 0, 1, 2]]}[frame]
        files |= {f"{foot}fcell": walk.cells[:, i], f"{foot}sole": np.hstack(
            [walk.feet[:, i], turned]
        )}  # fmt: skip
    paths = [tmp_path / f"walk5.{end}" for end in files]
    for path, values in zip(paths, files.values(), strict=True):
        np.savetxt(path, np.column_stack([walk.t, values]), fmt="%.6f")
    rng = np.random.default_rng(5)
    rows = [f"{foot}{k} {kg:.1f} {2.0 + k + 9.7 * kg + rng.normal(0, 0.1):.2f}"
            for foot in "LR" for k in range(4) for kg in (0, 5, 10, 20, 10, 5, 0)]  # fmt: skip
    bench = tmp_path / "kousei.dat"
    bench.write_text("\n".join(["# cell  omori[kg]  yomi[N]", *rows]) + "\n")
    found = _parts([bench, *paths])
    body, sensors = found["body"], found["cells"]
    motion = _columns(body.plan)
    end = {n: c.removeprefix("walk5.") for n, c in motion.items()}
    own = body.plan.file.path.name.removeprefix("walk5.")
    end = {n: c if "." in c else f"{own}.{c}" for n, c in end.items()}
    assert end["com_acc_x_mps2"] == "com.column_8"
    assert end["angmom_rate_z_nm"] == "amom.column_4"
    assert end["left_foot_z_m"] == "lsole.column_4"
    if frame == "rpy":
        assert end["right_foot_yaw_rad"] == "rsole.column_7"
    else:
        assert end["right_foot_qw"] == f"rsole.column_{8 if frame == 'xyzw' else 5}"
    assert len(sensors.beside) == 1
    names = found["weights"].plan.entries["channel"].names
    assert [names[f"{foot}0"].partition("_")[0] for foot in "LR"] == ["left", "right"]
    assert set(names.values()) == set(sensors.plan.channels)


def _stand(folder: Path, com: str, place: str, cells: str) -> list[Path]:
    """Stances between which the robot was put elsewhere: a file for each topic, stamps with gaps.

    `com` and `place` are what stands before the axis; cells are numbered from 0.
    """
    rng = np.random.default_rng(5)
    at = np.concatenate([40.0 * k + np.arange(0, 5, 0.05) for k in range(9)])
    stance = np.repeat(np.arange(9), at.size // 9)
    middle = rng.uniform(-0.5, 0.5, (9, 2))[stance]
    turn = rng.uniform(-0.3, 0.3, 9)[stance]

    def noisy(values: FloatArray) -> FloatArray:
        return np.asarray(values + rng.normal(0, 2e-4, values.shape))

    centre = np.column_stack([middle + rng.uniform(-0.02, 0.02, (9, 2))[stance],
                              np.full(at.size, 0.55)])  # fmt: skip
    paths = [_topic(folder / "estimator__state.csv", at, _xyz(com, noisy(centre)))]
    paths.append(_topic(folder / "stance_id.csv", np.linspace(0.0, 360.0, 10) + 0.004,
                        {"data": np.append(np.arange(1, 10), -1)}))  # fmt: skip
    four = Rotation.from_euler("z", turn[:, None]).as_quat()
    for side, way in (("left", 0.1), ("right", -0.1)):
        aside = way * np.column_stack([-np.sin(turn), np.cos(turn)])
        sole = np.column_stack([middle + aside, np.zeros(at.size)])
        pose = _xyz(place.format(side), noisy(sole))
        pose |= {f"pose.orientation.{a}": four[:, j] for j, a in enumerate("xyzw")}
        paths.append(_topic(folder / f"{side}_foot__sole.csv", at, pose, "odom"))
        read = {cells.format(k): rng.uniform(10, 40, 9)[stance] + noisy(at * 0) for k in range(4)}
        paths.append(_topic(folder / f"{side}_foot__load_cells.csv", at + 0.002, read))
    return paths


@pytest.mark.parametrize(("com", "place", "cells"), [
    ("point.", "pose.position.", "data[{}]"), ("pose.position.", "pose.position.", "force_{}"),
    ("com_", "{}_foot_", "data[{}]"), ("p_WCcm_", "X_W{}_", "data[{}]"),
])  # fmt: skip
def test_a_stand_in_a_file_for_each_topic(tmp_path: Path, com: str, place: str, cells: str) -> None:
    notes = tmp_path / "notes.md"
    notes.write_text(
        "Cells in the sole frame, in m:\n"
        "0 (0.08, 0.03), 1 (0.08, -0.03), 2 (-0.05, 0.03), 3 (-0.05, -0.03)\n"
    )
    files = [guess_file(path) for path in _stand(tmp_path, com, place, cells)]
    parts, others = parts_of(with_notes(files, [notes]))
    found = {part.plan.role: part.plan for part in parts}
    assert {*found} == {"cells", "body"}
    assert [file.path.name for file in others] == ["stance_id.csv"]
    motion = _columns(found["body"])
    assert motion["com_z_m"] == f"{com}z"
    assert motion["left_foot_x_m"] == f"left_foot__sole.{place.format('left')}x"
    assert motion["right_foot_qw"] == "right_foot__sole.pose.orientation.w"
    assert found["cells"].command == "static-init"
    assert "x_m = -0.05, y_m = -0.03" in found["cells"].robot[-1]


@pytest.mark.parametrize(("com", "sole"), [("com_", "X_W{}_"), ("p_WC_", "{}F."), ("com.", "T{}_")])
def test_soles_of_a_stand_by_one_letter_in_one_table(tmp_path: Path, com: str, sole: str) -> None:
    rng = np.random.default_rng(7)
    at, middle = np.arange(0, 40, 0.05), np.repeat(rng.uniform(-0.2, 0.2, (8, 3)), 100, axis=0)
    columns = {"t": at, **{f"cell_{k}": rng.normal(90, 9, at.size) for k in range(6)}}
    columns |= _xyz(com, middle * [1, 1, 0] + [0, 0, 0.6])
    four = Rotation.from_euler("z", 0.1 * middle[:, [2]]).as_quat()
    for letter, way in (("L", 0.1), ("R", -0.1)):
        columns |= _xyz(sole.format(letter), middle * [1, 1, 0] + [0, way, 0])
        columns |= {f"{sole.format(letter)}q{a}": four[:, i] for i, a in enumerate("xyzw")}
    path = tmp_path / "stand.csv"
    pd.DataFrame(columns).round(5).to_csv(path, index=False)
    motion = _columns(parts_of([guess_file(path)])[0][0].plan)
    assert motion["com_z_m"] == f"{com}z"
    assert motion["left_foot_y_m"] == f"{sole.format('L')}y"
    assert motion["right_foot_qw"] == f"{sole.format('R')}qw"

"""Walks on cells with a body's stream, in the names and layouts of many people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.plan import Entry, LogPlan
from footcal_cli.sniff.several import parts_of

STEP_S, HZ, MASS_KG = 0.6, 50.0, 40.0
SHARES = np.array([0.3, 0.2, 0.4, 0.1])


class Walk:
    """Feet that step in turn and turn along, a CoM between them, and what the cells carry.

    With four feet one at a time is in the air.
    """

    def __init__(self, sides: Sequence[float] = (0.1, -0.1), ahead: Sequence[float] = (0.0, 0.0)):
        rng = np.random.default_rng(3)
        self.t = np.arange(0.0, 3.0 + 16 * STEP_S, 1 / HZ)
        feet = len(sides)
        self.feet = np.zeros((self.t.size, feet, 3))
        self.rpy = np.zeros((self.t.size, feet, 3))
        self.air = np.zeros((self.t.size, feet))
        heading, start = np.zeros(feet), np.zeros((feet, 2))
        middle = np.array([0.3, -0.2])
        for i, (left, front) in enumerate(zip(sides, ahead, strict=True)):
            start[i] = middle + np.array([front, left])
        self.feet[:, :, :2], far = start, 0.0
        for k in range(16):
            i, at, far = k % feet, 1.5 + k * STEP_S, far + 0.05
            s = np.clip((self.t - at) / (0.7 * STEP_S), 0.0, 1.0)
            smooth = s**3 * (10 - 15 * s + 6 * s**2)
            angle = 0.04 * k
            ahead_m = np.array([np.cos(angle), np.sin(angle)])
            across = np.array([-ahead_m[1], ahead_m[0]])
            goal = middle + (far + ahead[i]) * ahead_m + sides[i] * across
            self.feet[:, i, :2] += smooth[:, None] * (goal - start[i])
            self.rpy[:, i, 2] += smooth * (angle - heading[i])
            self.rpy[:, i, 1] += 0.2 * np.sin(np.pi * s)
            self.feet[:, i, 2] += 0.05 * np.sin(np.pi * s) ** 2
            self.air[:, i] += (s > 0) & (s < 1)
            start[i], heading[i] = goal, angle
        self.com = np.append(self.feet.mean(axis=1)[:, :2], np.full((self.t.size, 1), 0.8), axis=1)
        window = np.hanning(17) / np.hanning(17).sum()
        padded = np.pad(self.com, ((8, 8), (0, 0)), mode="edge")
        self.com = np.stack([np.convolve(c, window, mode="valid") for c in padded.T], axis=1)
        self.com[:, 2] += 0.01 * np.sin(7 * self.t)
        self.vel = np.gradient(self.com, self.t, axis=0)
        self.acc = np.gradient(self.vel, self.t, axis=0)
        self.rate = np.stack([np.sin((9 + i) * self.t) for i in range(3)], axis=1)
        near = (1 - self.air) * (1 + 0.2 * np.sin(3 * self.t)[:, None] * np.arange(1, feet + 1))
        self.load = 9.81 * MASS_KG * near / near.sum(axis=1)[:, None]
        swing = 1 + 0.2 * np.sin(5 * self.t)[:, None] * np.array([1, -1, -0.5, 0.5])
        self.cells = self.load[:, :, None] * SHARES * swing[:, None, :]
        self.cells += rng.normal(0, 0.3, self.cells.shape)

    def counts(self, foot: int, cell: int) -> FloatArray:
        """A cell's reading in counts: 20 per N, a zero of its own."""
        return np.asarray(np.round(500 + 40 * cell + 20.0 * self.cells[:, foot, cell]))


def _xyz(stem: str, values: FloatArray, end: str = "") -> dict[str, FloatArray]:
    return {f"{stem}{axis}{end}": values[:, i] for i, axis in enumerate("xyz")}


def _written(path: Path, columns: Mapping[str, FloatArray], digits: int = 6) -> Path:
    pd.DataFrame(columns).round(digits).to_csv(path, index=False)
    return path


def _parts(paths: Sequence[Path]) -> dict[str, Part]:
    parts, others = parts_of([guess_file(path) for path in paths])
    assert not others
    return {part.plan.role: part for part in parts}


def _columns(plan: LogPlan) -> dict[str, str]:
    return {name: e.column.column for name, e in plan.entries.items() if e.column is not None}


def _bench(path: Path, cells: Mapping[str, str], order: bool = False) -> Path:
    """A weight on one cell after another; 20 counts per N."""
    rows = [
        {"sensa": cell, "fundou_kg": kg, **({"ban": i} if order else {}), said: 500 + 196.2 * kg}
        for cell, said in cells.items() for i, kg in enumerate((0, 2, 5, 10, 5, 2, 0))
    ]  # fmt: skip
    pd.DataFrame(rows).to_csv(path, index=False)
    return path


def test_a_body_in_romaji_and_a_bench_with_an_order_number(tmp_path: Path) -> None:
    walk = Walk()
    places = ("mae_hidari", "mae_migi", "ushiro_hidari", "ushiro_migi")
    cells = {
        f"{side}_{place}": walk.counts(i, k)
        for i, side in enumerate(("hidari", "migi")) for k, place in enumerate(places)
    }  # fmt: skip
    body = {"jikoku_s": walk.t, **_xyz("juushin_", walk.com), **_xyz("juushin_kasokudo_", walk.acc)}
    body |= _xyz("kakuundouryou_henka_", walk.rate)
    for i, side in enumerate(("hidari", "migi")):
        body |= _xyz(f"{side}_ashi_", walk.feet[:, i])
        angles = dict(zip(("roll", "pitch", "yaw"), walk.rpy[:, i].T, strict=True))
        body |= {f"{side}_ashi_{angle}": values for angle, values in angles.items()}
    found = _parts([
        _written(tmp_path / "kajuu.csv", {"jikoku_s": walk.t, **cells}),
        _bench(tmp_path / "kousei.csv", dict.fromkeys(cells, "yomi_N"), order=True),
        _written(tmp_path / "shintai.csv", body),
    ])  # fmt: skip
    assert set(found) == {"cells", "weights", "body"}
    assert _columns(found["cells"].plan)["left_fr_counts"] == "hidari_mae_migi"
    motion = _columns(found["body"].plan)
    assert motion["com_acc_z_mps2"] == "juushin_kasokudo_z"
    assert motion["angmom_rate_x_nm"] == "kakuundouryou_henka_x"
    assert motion["right_foot_pitch_rad"] == "migi_ashi_pitch"
    weights = found["weights"].plan
    assert _columns(weights)["counts"] == "yomi_N"
    assert set(weights.channels) == set(found["cells"].plan.channels)


@pytest.mark.parametrize("last", [True, False])
def test_each_foot_in_a_file_and_a_bench_of_both_feet(tmp_path: Path, last: bool) -> None:
    walk = Walk()
    paths = []
    for i, side in enumerate(("left", "right")):
        cells = {f"ch{k + 1}": walk.counts(i, k) for k in range(4)}
        paths.append(_written(tmp_path / f"lc_{side}.csv", {"stamp": walk.t, **cells}))
    body = {"stamp": walk.t, **_xyz("c", walk.com), **_xyz("cd", walk.vel), **_xyz("cdd", walk.acc)}
    body |= _xyz("Ldot_", walk.rate)
    for i, foot in enumerate(("lf", "rf")):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        body |= _xyz(f"{foot}_p", walk.feet[:, i])
        quaternion = {f"{foot}_q{a}": four[:, j] for j, a in enumerate("xyzw")}
        body |= quaternion if last else dict(sorted(quaternion.items()))
    rows = [
        {"foot": side, "loaded_channel": k + 1, "kg": kg,
         **{f"ch{j + 1}": 500 + 40 * j + 196.2 * kg * (j == k) + 7 * i for j in range(4)}}
        for i, side in enumerate(("left", "right")) for k in range(4) for kg in (0, 5, 10, 20)
    ]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "bench.csv", index=False)
    found = _parts([tmp_path / "bench.csv", *paths, _written(tmp_path / "estimator.csv", body)])
    cells_plan, motion = found["cells"].plan, _columns(found["body"].plan)
    assert _columns(cells_plan)["left_ch1_counts"] == "ch1"
    assert _columns(cells_plan)["right_ch4_counts"] == "lc_right.ch4"
    assert motion["com_acc_x_mps2"] == "cddx"
    assert motion["left_foot_qw"] == "lf_qw"
    assert "com_vel_x_mps" not in motion
    wide = found["weights"].plan.wide
    assert set(wide) == set(cells_plan.channels)
    load = wide["right_ch2"]["load_n"]
    assert load.only_where == {"foot": "right", "loaded_channel": "2"}


def test_one_table_of_a_walk_with_feet_by_letters_and_a_column_for_each_cell_of_the_bench(
    tmp_path: Path,
) -> None:
    walk = Walk()
    log = {"t": walk.t, **_xyz("cdm_", 1e3 * walk.com, "_mm"), **_xyz("cdm_v", walk.vel, "_ms")}
    for i, letter in enumerate("id"):
        log |= _xyz(f"p{letter}_", 1e3 * walk.feet[:, i], "_mm")
        log[f"p{letter}_guinada_grados"] = np.degrees(walk.rpy[:, i, 2])
    log |= {f"lc_{c}{k + 1}": walk.counts(i, k) for i, c in enumerate("id") for k in range(4)}
    masses = np.array([0, 1, 2, 3, 4, 5, 6.0])
    bench = {"kg": masses} | {
        f"{c}{k + 1}": np.round(300.0 + 50 * k + 990 * masses + (masses == 2))
        for c in "id" for k in range(4)
    }  # fmt: skip
    found = _parts([
        _written(tmp_path / "banco.csv", bench), _written(tmp_path / "caminata.csv", log, 4)
    ])  # fmt: skip
    plan, bench_plan = found["cells"].plan, found["weights"].plan
    columns = _columns(plan)
    assert columns["left_3_counts"] == "lc_i3"
    assert columns["right_1_counts"] == "lc_d1"
    assert columns["com_vel_y_mps"] == "cdm_vy_ms"
    assert plan.entries["right_foot_yaw_rad"].unit == "deg"
    assert plan.entries["com_z_m"].unit == "mm"
    counts = {name: own["counts"].column for name, own in bench_plan.wide.items()}
    assert {n: c.column for n, c in counts.items() if c} == {
        f"{side}_{k + 1}": f"{c}{k + 1}"
        for side, c in (("left", "i"), ("right", "d")) for k in range(4)
    }  # fmt: skip


def test_names_that_say_nothing_are_read_by_what_the_numbers_do(tmp_path: Path) -> None:
    """Feet by their geometry, cells by when they rest."""
    walk = Walk()
    body = {"t_s": walk.t, **_xyz("u.", walk.com), **_xyz("v.", walk.acc), **_xyz("w.", walk.rate)}
    for name, i in (("p", 1), ("q", 0)):
        body |= _xyz(f"{name}.", walk.feet[:, i])
        body[f"{name}.yaw"] = walk.rpy[:, i, 2]
    cells = {"t_s": walk.t} | {
        f"k{n}": walk.counts(i, k) for n, (i, k) in enumerate(np.ndindex(2, 4))
    }  # fmt: skip
    found = _parts([_written(tmp_path / "a.csv", cells), _written(tmp_path / "b.csv", body)])
    motion = _columns(found["body"].plan)
    assert motion["left_foot_x_m"] == "q.x"
    assert motion["com_acc_x_mps2"] == "v.x"
    assert motion["angmom_rate_y_nm"] == "w.y"
    own = {n: c for n, c in _columns(found["cells"].plan).items() if n.endswith("_counts")}
    assert {c for n, c in own.items() if n.startswith("left_")} == {"k0", "k1", "k2", "k3"}


def test_four_feet_with_cells_of_their_own(tmp_path: Path) -> None:
    walk, legs = Walk((0.1, -0.1, 0.1, -0.1), (0.25, 0.25, -0.25, -0.25)), ("FL", "FR", "HL", "HR")
    body = {"time": walk.t, **_xyz("com.", walk.com), **_xyz("com_vel.", walk.vel)}
    body |= {**_xyz("com_acc.", walk.acc), **_xyz("hdot.", walk.rate)}
    for i, leg in enumerate(legs):
        body |= _xyz(f"{leg}.", walk.feet[:, i]) | {f"{leg}.yaw": walk.rpy[:, i, 2]}
    cells = {f"{leg}_{c}": walk.counts(i, k) for i, leg in enumerate(legs)
             for k, c in enumerate("abc")}  # fmt: skip
    bench = _bench(tmp_path / "c.csv", dict.fromkeys(cells, "counts"))
    found = _parts([
        _written(tmp_path / "base.csv", body), bench,
        _written(tmp_path / "pads.csv", {"time": walk.t, **cells}),
    ])  # fmt: skip
    assert _columns(found["cells"].plan)["hr_b_counts"] == "HR_b"
    assert _columns(found["body"].plan)["hl_foot_yaw_rad"] == "HL.yaw"
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)


def test_a_bench_without_a_unit_says_what_kilograms_of_a_walk_are(tmp_path: Path) -> None:
    walk = Walk()
    cells = {
        f"{side}_{k + 1}_kg": walk.cells[:, i, k] / 9.81
        for i, side in enumerate(("izq", "der")) for k in range(4)
    }  # fmt: skip
    body = {"t_s": walk.t, **_xyz("cdm_", walk.com, "_m")}
    for i, side in enumerate(("izq", "der")):
        body |= _xyz(f"pie_{side}_", walk.feet[:, i], "_m")
    names = [name.removesuffix("_kg") for name in cells]
    rows = [
        {"celda": on, "pesa_kg": kg,
         **{f"lectura_{n}": round(0.1 + 0.98 * kg * (n == on), 3) for n in names}}
        for on in names for kg in (0, 1, 2, 5)
    ]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "cal.csv", index=False)
    found = _parts([
        tmp_path / "cal.csv", _written(tmp_path / "celdas.csv", {"t_s": walk.t, **cells}, 3),
        _written(tmp_path / "cuerpo.csv", body),
    ])  # fmt: skip
    read: Entry = found["cells"].plan.entries["left_2_counts"]
    assert read.unit is None
    assert set(found["weights"].plan.wide) == set(found["cells"].plan.channels)


def test_an_order_number_is_no_reading_whatever_the_columns_are_called(tmp_path: Path) -> None:
    masses, rng = np.tile([0.0, 2, 5, 10, 5, 2, 0], 3), np.random.default_rng(1)
    log = tmp_path / "a.csv"
    columns = {
        "abc": np.repeat(["p", "q", "r"], 7), "def_kg": masses, "ghi": np.tile(np.arange(7), 3),
        "jkl_N": 4.0 + 9.9 * masses + rng.normal(0, 0.05, masses.size),
    }  # fmt: skip
    pd.DataFrame(columns).to_csv(log, index=False)
    plan = _parts([log])["weights"].plan
    assert {n: c for n, c in _columns(plan).items() if n != "time_s"} == {
        "load_n": "def_kg", "channel": "abc", "counts": "jkl_N"
    }  # fmt: skip


LEGS = ("LF", "RF", "LH", "RH")


def test_a_file_for_each_leg_and_soles_called_after_them(tmp_path: Path) -> None:
    walk = Walk((0.1, -0.1, 0.1, -0.1), (0.2, 0.2, -0.2, -0.2))
    body = {"t": walk.t, **_xyz("CoM", walk.com), **_xyz("CoMAcc", walk.acc)}
    body |= _xyz("HDot", walk.rate)
    paths = []
    for i, leg in enumerate(LEGS):
        cells = {name: walk.counts(i, k) for k, name in enumerate("abc")}
        paths.append(_written(tmp_path / f"foot_{leg}.csv", {"t": walk.t + 0.0003 * i, **cells}))
        body |= _xyz(leg, walk.feet[:, i])
        angles = zip(("Roll", "Pitch", "Yaw"), walk.rpy[:, i].T, strict=True)
        body |= {f"{leg}{angle}": values for angle, values in angles}
    body = {name.replace("x", "X").replace("y", "Y").replace("z", "Z"): v
            for name, v in body.items()}  # fmt: skip
    body = {name.replace("YaW", "Yaw"): values for name, values in body.items()}
    found = _parts([*paths, _written(tmp_path / "body.csv", body)])
    expected = [f"{leg}_{c}" for leg in ("fl", "fr", "hl", "hr") for c in "abc"]
    assert sorted(found["cells"].plan.channels) == sorted(expected)
    assert len(found["cells"].beside) == 3
    motion = _columns(found["body"].plan)
    assert motion["hl_foot_x_m"] == "LHX"
    assert motion["fr_foot_yaw_rad"] == "RFYaw"
    assert motion["angmom_rate_y_nm"] == "HDotY"
    assert found["body"].plan.command == "online-replay"


@pytest.mark.parametrize(
    ("word", "unit"),
    [
        ("r", "rad"), ("rot_", "deg"), ("ang_", "rad"),
        *(pytest.param(*both, marks=pytest.mark.slow)
          for both in (("r", "deg"), ("rot_", "rad"), ("ang_", "deg"))),
    ],
)  # fmt: skip
def test_angles_of_soles_by_their_axes(tmp_path: Path, word: str, unit: str) -> None:
    walk = Walk()
    cells = {f"{side}{k}": walk.counts(i, k) for i, side in enumerate("LR") for k in range(4)}
    body = {"tempo": walk.t, **_xyz("cm_", walk.com), **_xyz("acel_cm_", walk.acc)}
    for i, side in enumerate(("esq", "dir")):
        body |= _xyz(f"planta_{side}_", walk.feet[:, i])
        size = np.pi / 180 if unit == "deg" else 1.0
        body |= _xyz(f"planta_{side}_{word}", walk.rpy[:, i] / size)
    found = _parts([_written(tmp_path / "pes.csv", {"tempo": walk.t, **cells}),
                    _written(tmp_path / "corpo.csv", body)])  # fmt: skip
    plan = found["body"].plan
    assert _columns(plan)["left_foot_roll_rad"] == f"planta_esq_{word}x"
    assert plan.entries["right_foot_yaw_rad"].unit == unit

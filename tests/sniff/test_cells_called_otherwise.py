"""Walks whose cells have other names than on the bench: serial numbers, a file for each foot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from tests.sniff.test_walks import Walk, _columns, _parts, _written, _xyz


@pytest.mark.parametrize(("between", "unit"), [("_", "N"), (" ", "kgf")])
def test_serial_numbers_behind_a_unit_and_a_bench_with_dashes(
    tmp_path: Path, between: str, unit: str
) -> None:
    walk = Walk()
    serials = [f"17{between}04{n}" for n in (12, 15, 16, 21, 30, 31, 33, 38)]
    size = 1.0 if unit == "N" else 1 / 9.80665
    cells = {f"{unit}{between}{serial}": size * walk.cells[:, i, k]
             for serial, (i, k) in zip(serials, np.ndindex(2, 4), strict=True)}  # fmt: skip
    body = {"t": walk.t, **_xyz("zwpt_", walk.com), **_xyz("zwpt_a_", walk.acc)}
    for i, side in enumerate(("links", "rechts")):
        body |= _xyz(f"H_{side}_p", walk.feet[:, i])
    rows = [{"serienummer": serial.replace(between, "-"), "last_N": load,
             f"uitlezing_{unit}": 0.3 + 1.01 * size * load}
            for serial in serials for load in (0, 50, 100, 50, 0)]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "ijking.csv", index=False)
    found = _parts([
        tmp_path / "ijking.csv", _written(tmp_path / "krachten.csv", {"t": walk.t, **cells}),
        _written(tmp_path / "toestand.csv", body),
    ])  # fmt: skip
    plan = found["cells"].plan
    assert plan.command == "online-replay"
    assert _columns(plan)["left_0412_counts"] == f"{unit}{between}17{between}0412"
    assert _columns(plan)["right_0438_counts"] == f"{unit}{between}17{between}0438"
    assert plan.entries["right_0430_counts"].unit == unit
    assert set(found["weights"].plan.channels) == set(plan.channels)


@pytest.mark.parametrize("body", [True, False])
@pytest.mark.parametrize(
    ("foot", "sides", "turns"),
    [
        ("noha", ("leva", "prava"), ("klopeni_x", "klopeni_y", "natoceni_z")),
        ("ayak", ("sol", "sag"), ("egim_x", "egim_y", "donus_z")),
        ("stopalo", ("lijeva", "desna"), ("tilt_x", "tilt_y", "turn_z")),
    ],
)
def test_a_file_for_each_foot_and_kind(
    tmp_path: Path, foot: str, sides: tuple[str, str], turns: tuple[str, ...], body: bool
) -> None:
    """Angles about axes are no cells, and the files of both feet's cells are two feet."""
    walk, cells = Walk(), ("PL", "PP", "ZL", "ZP")
    sway = np.random.default_rng(4).normal(0, 0.002, walk.rpy[:, 0].shape)
    paths, rows = [], []
    for i, side in enumerate(sides):
        read = {f"F_{cell}_N": walk.cells[:, i, k] for k, cell in enumerate(cells)}
        paths.append(_written(tmp_path / f"{foot}_{side}_f.csv", {"t_s": walk.t, **read}, 3))
        if body:
            pose = {"t_s": walk.t, **_xyz("", 1e3 * walk.feet[:, i], "_mm")}
            angles = zip(turns, np.degrees(walk.rpy[:, i] + sway).T, strict=True)
            pose |= {f"{name}_st": values for name, values in angles}
            paths.append(_written(tmp_path / f"{foot}_{side}_p.csv", pose, 3))
        rows += [{foot: side, "snimac": cell, "kg": kg, "udaj_N": round(0.2 + 9.9 * kg, 2)}
                 for cell in cells for kg in (0, 1, 2, 5, 2, 0)]  # fmt: skip
    if body:
        com = {"t_s": walk.t, **_xyz("T_", 1e3 * walk.com, "_mm")}
        com |= _xyz("a_", 1e3 * walk.acc, "_mm_s2")
        paths.append(_written(tmp_path / "teziste.csv", com, 3))
    pd.DataFrame(rows).to_csv(tmp_path / "bench.csv", index=False)
    found = _parts([tmp_path / "bench.csv", *sorted(paths)])
    assert set(found) == {"weights", "cells", *(["body"] if body else [])}
    read_as = _columns(found["cells"].plan)
    head = "" if body else "f_"
    joined = found["cells"].beside[0].file.path.stem
    other = "right" if sides[1] in joined else "left"
    assert read_as[f"{other}_{head}zp_counts"] == f"{joined}.F_ZP_N"
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)
    assert len(found["cells"].plan.channels) == 8
    if body:
        motion = found["body"].plan.entries
        assert motion["left_foot_roll_rad"].unit == motion["right_foot_yaw_rad"].unit == "deg"
        assert found["body"].plan.command == "online-replay"


@pytest.mark.parametrize("clock", ["aika_s", "hetki_s", "t_ms"])
def test_a_row_for_each_time_and_cell_next_to_a_bench(tmp_path: Path, clock: str) -> None:
    walk, cells = Walk(), [f"{foot}{k}" for foot in "VO" for k in (1, 2, 3, 4)]
    stamps = (1e3 if clock == "t_ms" else 1.0) * walk.t
    long = pd.DataFrame({
        clock: np.repeat(stamps, len(cells)).round(4), "anturi": np.tile(cells, walk.t.size),
        "arvo_N": walk.cells.reshape(walk.t.size, -1).ravel().round(2),
    })  # fmt: skip
    long.to_csv(tmp_path / "anturit.csv", index=False)
    body = {clock: stamps, **_xyz("painopiste_", walk.com), **_xyz("kiihtyvyys_", walk.acc)}
    for i, side in enumerate(("vasen", "oikea")):
        body |= _xyz(f"{side}_pohja_", walk.feet[:, i])
    rows = [{"anturi": cell, "punnus_kg": kg, "lukema_N": round(0.1 * n + 9.9 * kg, 3)}
            for n, cell in enumerate(cells) for kg in (0, 5, 10, 20, 5, 0)]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "kalibrointi.csv", index=False)
    found = _parts([tmp_path / "anturit.csv", tmp_path / "kalibrointi.csv",
                    _written(tmp_path / "tila.csv", body)])  # fmt: skip
    assert set(found) == {"weights", "cells", "body"}
    read = _columns(found["cells"].plan)
    assert (read["time_s"], read["right_4_counts"]) == (clock, "O4.arvo_N")
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)


@pytest.mark.parametrize("head", ["X", "cell"])
def test_a_sheet_for_each_cell_of_a_walk(tmp_path: Path, head: str) -> None:
    """The cells of sheets are called as those of the walk are, and 1 daN is 10 N in both."""
    walk, paths = Walk(), []
    names = [f"{head}{foot}{k}" for foot in (1, 2) for k in (1, 2, 3, 4)]
    cells = {f"{name}_daN": walk.cells[:, i, k] / 10
             for name, (i, k) in zip(names, np.ndindex(2, 4), strict=True)}  # fmt: skip
    for n, name in enumerate(names):
        rows = [f"Connector;{name}", "", "Point;Load [daN];Indication [daN]"]
        rows += [f"{i};{load};{0.05 * n + (1 + 0.01 * n) * load:.3f}"
                 for i, load in enumerate((0.0, 10.0, 20.0, 50.0, 20.0, 0.0))]  # fmt: skip
        paths.append(tmp_path / f"sheet_{name}.csv")
        paths[-1].write_text("\n".join(rows) + "\n", encoding="utf-8")
    body = {"t_s": walk.t, **_xyz("com_", walk.com), **_xyz("com_acc_", walk.acc)}
    for i, side in enumerate(("left", "right")):
        body |= _xyz(f"{side}_sole_", walk.feet[:, i])
    found = _parts([*paths, _written(tmp_path / "cells.csv", {"t_s": walk.t, **cells}, 4),
                    _written(tmp_path / "state.csv", body)])  # fmt: skip
    plan, bench = found["cells"].plan, found["weights"].plan
    assert set(bench.channels) == set(plan.channels)
    assert set(bench.entries["channel"].names.values()) == set(plan.channels)
    assert plan.entries["left_2_counts"].unit == bench.entries["counts"].unit == "daN"
    assert not any("newtons a count" in blank.why for blank in plan.blanks)


@pytest.mark.parametrize(
    "legs", [("AVG", "AVD", "ARG", "ARD"), ("q1", "q2", "q3", "q4"), ("FL", "FR", "HL", "HR")]
)
def test_a_file_for_each_leg_with_its_cells_and_its_pose(
    tmp_path: Path, legs: tuple[str, ...]
) -> None:
    walk = Walk((0.1, -0.1, 0.1, -0.1), (0.2, 0.2, -0.2, -0.2))
    paths, rows = [], []
    for i, leg in enumerate(legs):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        log = {"t": walk.t, **{f"F{k + 1}": walk.cells[:, i, k] for k in range(3)}}
        log |= _xyz("p", walk.feet[:, i]) | {f"q{a}": four[:, j] for j, a in enumerate("xyzw")}
        paths.append(_written(tmp_path / f"marche_09_{leg}.csv", log))
        rows += [{"patte": leg, "capteur": f"F{k + 1}", "masse_kg": kg,
                  "lecture_N": round(3 * i + k + (9 + 0.1 * k + 0.3 * i) * kg, 3)}
                 for k in range(3) for kg in (0, 1, 2, 5, 2, 0)]  # fmt: skip
    body = {"t": walk.t, **_xyz("c_", walk.com), **_xyz("ddc_", walk.acc)}
    paths.append(_written(tmp_path / "marche_09_corps.csv", body))
    pd.DataFrame(rows).to_csv(tmp_path / "etalonnage.csv", index=False)
    found = _parts([tmp_path / "etalonnage.csv", *sorted(paths)])
    assert set(found) == {"weights", "cells"}
    cells, read = found["cells"].plan, _columns(found["cells"].plan)
    assert cells.command == "online-replay"
    assert len(cells.channels) == 12
    assert set(found["weights"].plan.channels) == set(cells.channels)
    assert len(found["cells"].beside) == 4
    for leg in legs:
        foot, before = leg.lower(), f"marche_09_{leg}."
        before = "" if f"{before}csv" == cells.file.path.name else before
        assert read[f"{foot}_f2_counts"] == f"{before}F2"
        assert read[f"{foot}_foot_x_m"] == f"{before}px"
        assert read[f"{foot}_foot_qw"] == f"{before}qw"

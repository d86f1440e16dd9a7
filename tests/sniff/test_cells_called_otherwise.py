"""Walks whose cells have other names than on the bench: serial numbers, a file for each foot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

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

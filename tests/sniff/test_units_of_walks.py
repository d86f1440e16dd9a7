"""Walks in units that no column says, feet that names say twice, and frames called otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.foot_mounts import foot_mount
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.units import split_unit
from tests.sniff.test_walks import Walk, _bench, _columns, _parts, _written, _xyz

FOUR = {"sides": (0.1, -0.1, 0.1, -0.1), "ahead": (0.2, 0.2, -0.2, -0.2)}


def _cells(walk: Walk, names: tuple[str, ...], places: tuple[str, ...]) -> dict[str, FloatArray]:
    return {f"{name}_{place}": walk.counts(i, k)
            for i, name in enumerate(names) for k, place in enumerate(places)}  # fmt: skip


@pytest.mark.parametrize("name", ["Anzeige_mV/V", "cell mV/V", "U_mV_V", "lectura.mV/V"])
def test_a_ratio_is_no_voltage(name: str) -> None:
    assert split_unit(name)[1] == "mV/V"


@pytest.mark.parametrize(("length", "size"), [("cm", 1e2), ("mm", 1e3), ("m", 1.0)])
def test_lengths_and_angles_by_their_size(tmp_path: Path, length: str, size: float) -> None:
    """A CoM of 80 is one in cm; a sole that pitches by 11 in a straight walk does so in degrees."""
    walk = Walk()
    body = {"ms": 1e3 * walk.t, **_xyz("com_", size * walk.com)}
    for i, foot in enumerate("lr"):
        body |= _xyz(f"{foot}sole_", size * walk.feet[:, i])
        rpy = np.degrees(walk.rpy[:, i] * [1.0, 1.0, 1e-3])
        body |= dict(zip((f"{foot}sole_{a}" for a in ("roll", "pitch", "yaw")), rpy.T, strict=True))
    cells = {"ms": 1e3 * walk.t, **_cells(walk, ("L", "R"), ("FL", "FR", "RL", "RR"))}
    found = _parts([_written(tmp_path / "c.csv", cells, 3), _written(tmp_path / "b.csv", body, 4)])
    entries = found["body"].plan.entries
    assert entries["com_z_m"].unit in ((length,) if length != "m" else ("m", None))
    assert entries["left_foot_x_m"].unit == length
    assert {entries[f"right_foot_{a}_rad"].unit for a in ("roll", "pitch", "yaw")} == {"deg"}


@pytest.mark.parametrize(("unit", "per_m"), [("ft", 1 / 0.3048), ("in", 1 / 0.0254), ("mm", 1e3)])
def test_accelerations_in_the_unit_in_which_the_place_moves(
    tmp_path: Path, unit: str, per_m: float
) -> None:
    walk = Walk()
    body = {"Time_s": walk.t, **_xyz("CoM_", walk.com / 0.0254, "_in")}
    body |= _xyz("CoMAcc_", walk.acc * per_m, f"_{unit}_s2")
    for i, foot in enumerate(("Left", "Right")):
        body |= _xyz(f"{foot}Sole_", walk.feet[:, i] / 0.0254, "_in")
    zones = ("ToeLeft", "ToeRight", "HeelLeft", "HeelRight")
    cells = _cells(walk, ("LF", "RF"), zones)
    bench = _bench(tmp_path / "bench.csv", dict.fromkeys(cells, "Mean"))
    found = _parts([
        bench, _written(tmp_path / "cells.csv", {"Time_s": walk.t, **cells}),
        _written(tmp_path / "state.csv", body),
    ])  # fmt: skip
    assert found["body"].plan.entries["com_acc_y_mps2"].unit == f"{unit}/s^2"
    channels = found["cells"].plan.channels
    assert {c.partition("_")[0] for c in channels[:4]} == {"left"}
    assert {c.partition("_")[0] for c in channels[4:]} == {"right"}
    assert set(found["weights"].plan.channels) == set(channels)


def test_the_foot_comes_before_the_side_of_a_zone() -> None:
    said = {n: name_guess(n) for n in ("LF_ToeRight", "left_heel_right", "L_toe_r", "heel_left")}
    assert [(g.side, g.place) for g in said.values()] == [
        ("left", "toe_right"), ("left", "heel_right"), ("left", "toe_right"), ("left", "heel"),
    ]  # fmt: skip


def test_a_walk_in_kilograms_of_force_in_one_table_with_its_motion(tmp_path: Path) -> None:
    walk = Walk()
    log = {"X_Value": walk.t}
    log |= {f"{foot}F{k + 1} [kgf]": walk.cells[:, i, k] / 9.80665
            for i, foot in enumerate("LR") for k in range(4)}  # fmt: skip
    log |= _xyz("CoM_", walk.com, " [m]") | _xyz("CoM_acc_", walk.acc, " [m/s2]")
    for i, foot in enumerate("LR"):
        log |= _xyz(f"{foot}sole_", walk.feet[:, i], " [m]")
    masses = np.array([0, 10, 20, 40, 20, 10, 0.0])
    bench = {"Load_kgf": masses}
    names, rng = [name for name in log if "F" in name], np.random.default_rng(2)
    bench |= {n: k + 0.99 * masses + rng.normal(0, 0.02, 7) for k, n in enumerate(names)}
    found = _parts([_written(tmp_path / "B.csv", bench, 3), _written(tmp_path / "W.csv", log)])
    plan = found["cells"].plan
    assert _columns(plan)["right_2_counts"] == "RF2 [kgf]"
    assert plan.command == "online-replay"
    assert set(found["weights"].plan.wide) == set(plan.channels)


def test_legs_in_a_language_that_no_list_knows_with_a_cell_each(tmp_path: Path) -> None:
    """DE is dianteira esquerda; rol, arf and gui are short for the angles."""
    walk, legs = Walk(FOUR["sides"], FOUR["ahead"]), ("DE", "DD", "TE", "TD")
    body = {"tempo_s": walk.t, **_xyz("cm_", walk.com, "_m"), **_xyz("cm_a", walk.acc, "_m_s2")}
    for i, leg in enumerate(legs):
        body |= _xyz(f"pe_{leg}_", walk.feet[:, i], "_m")
        angles = np.degrees(walk.rpy[:, i]).T
        names = (f"pe_{leg}_{a}_graus" for a in ("rol", "arf", "gui"))
        body |= dict(zip(names, angles, strict=True))
    cells = {f"celula_{leg}_kgf": walk.load[:, i] / 9.81 for i, leg in enumerate(legs)}
    rows = [{"celula": leg, "peso_kg": kg, "leitura_kgf": 0.02 + 0.99 * kg}
            for leg in legs for kg in (0, 1, 2, 5, 10, 5, 2, 1, 0)]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "cal.csv", index=False)
    found = _parts([
        tmp_path / "cal.csv", _written(tmp_path / "celulas.csv", {"tempo_s": walk.t, **cells}),
        _written(tmp_path / "estado.csv", body),
    ])  # fmt: skip
    assert found["cells"].plan.channels == ("de_foot", "dd_foot", "te_foot", "td_foot")
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)
    motion = found["body"].plan.entries
    assert motion["td_foot_pitch_rad"].unit == "deg"
    assert _columns(found["body"].plan)["de_foot_yaw_rad"] == "pe_DE_gui_graus"


def _turned_by(walk: Walk, sign: float, turn: FloatArray) -> dict[str, FloatArray]:
    """What transducers at two feet read of a walk, in frames that `turn` takes to the feet's."""
    whole = 40.0 * (walk.acc + np.array([0.0, 0.0, 9.81]))
    share = (1 - walk.air) / np.maximum((1 - walk.air).sum(axis=1), 1)[:, None]
    made = {"time": walk.t}
    for i, foot in enumerate(("left", "right")):
        sole = Rotation.from_euler("xyz", walk.rpy[:, i])
        read = sign * sole.inv().apply(whole * share[:, [i]]) @ turn
        made |= _xyz(f"{foot}_ankle_ft.f_", read) | _xyz(f"{foot}_ankle_ft.tau_", 0.01 * read)
    return made


def _drake(walk: Walk) -> dict[str, FloatArray]:
    """``p_WCcm``, ``q_WLSole``: names whose beginning says what, and whose middle says whose."""
    body = {"time": walk.t, **_xyz("p_WCcm_", walk.com), **_xyz("a_WCcm_", walk.acc)}
    for i, foot in enumerate("LR"):
        four = Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat()
        body |= _xyz(f"p_W{foot}Sole_", walk.feet[:, i])
        body |= {
            f"q_W{foot}Sole_{a}": four[:, j] for a, j in zip("wxyz", (3, 0, 1, 2), strict=True)
        }
    return body


@pytest.mark.parametrize(("sign", "turn", "angle"), [
    (1.0, np.diag([1.0, -1.0, -1.0]), np.pi), (-1.0, np.eye(3), 0.0), (1.0, np.eye(3), 0.0),
])  # fmt: skip
def test_upside_down_is_no_reversed_sign(
    tmp_path: Path, sign: float, turn: FloatArray, angle: float
) -> None:
    walk = Walk()
    found = _parts([
        _written(tmp_path / "ft.csv", _turned_by(walk, sign, turn)),
        _written(tmp_path / "state.csv", _drake(walk)),
    ])  # fmt: skip
    plan = found["cells"].plan
    columns: Mapping[str, str] = _columns(found["body"].plan)
    assert columns["right_foot_qw"] == "q_WRSole_w"
    assert {e.factor for n, e in plan.entries.items() if n != "time_s"} == (
        {None} if sign > 0 else {-1.0}
    )
    assert bool(plan.mounting) == (angle > 0)
    six = {foot: {a: plan.entries[f"{foot}_{a}_n"].column for a in ("fx", "fy", "fz")}
           for foot in ("left", "right")}  # fmt: skip
    mount = foot_mount(six, found["body"].plan.entries)  # type: ignore[arg-type]
    assert mount is not None
    assert np.allclose(mount.rotation, turn)
    assert mount.sign == sign

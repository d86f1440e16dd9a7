"""Six axes in several files: poses beside a hanging, numbered joints, units that no name says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.foot_angles import angle_unit
from footcal_cli.sniff.guesses import ColumnGuess
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.several import parts_of
from footcal_cli.sniff.triples import Axes
from tests.strangers.rigs import Array, Rng, rows, wrist, write

LEGS = ("DE", "DD", "TE", "TD")
AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
HUNG = {"zup": (0.0, 0.0), "xup": (0.0, -90.0), "zdown": (180.0, 0.0), "xdown": (0.0, 90.0)}
WEIGHT_N = 12.0


def hung(turn: Rotation, angle: Array, rng: Rng) -> Array:
    """Wrenches (n, 6) of a leg whose transducer is parallel to the body."""
    force = WEIGHT_N * turn.inv().apply([0.0, 0.0, -1.0])
    com = Rotation.from_euler("y", angle[:, None]).apply([0.0, 0.05, -0.1])
    whole = np.hstack([np.tile(force, (len(com), 1)), np.cross(com, force)])
    return np.asarray(whole + rng.normal(0, [0.02] * 3 + [0.002] * 3, whole.shape))


def stood(turn: Rotation, rng: Rng) -> Array:
    """Wrenches (4, 6) of legs that share a robot's weight."""
    share = rng.dirichlet([20.0] * 4)
    force = -140.0 * share[:, None] * turn.inv().apply([0.0, 0.0, -1.0])
    return np.asarray(np.hstack([force, rng.normal(0, 2, (4, 3))]))


def parts(*paths: Path) -> dict[str, Part]:
    """The parts of what `init` makes of logs, by their roles."""
    found, others = parts_of([guess_file(path) for path in paths])
    assert not others
    return {part.plan.role: part for part in found}


def test_poses_with_a_sheet_beside_a_hanging(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    lines = ["setting,roll_deg,pitch_deg,yaw_deg,t_s,leg,hip_phase_deg," + ",".join(AXES)]
    for word, (roll, pitch) in HUNG.items():
        turn = Rotation.from_euler("xyz", [roll, pitch, 0.0], degrees=True)
        for leg in LEGS:
            angle = np.linspace(-1.0, 1.0, 40)
            body = rows(0.1 * np.arange(40), form="%.1f")
            read = rows(np.degrees(angle), *hung(turn, angle, rng).T, form="%.4f")
            lines += [
                f"{word},{roll},{pitch},0,{t},{leg},{r}" for t, r in zip(body, read, strict=True)
            ]
    hang = write(tmp_path / "hang.csv", lines)
    table, sheet = ["pose,leg,hip_phase_deg," + ",".join(AXES)], ["pose,roll_deg,pitch_deg,yaw_deg"]
    for pose in range(1, 13):
        roll, pitch, yaw = rng.uniform([-5, -5, -180], [5, 5, 180])
        turn = Rotation.from_euler("xyz", [roll, pitch, yaw], degrees=True)
        read = rows(rng.uniform(-40, 40, 4), *stood(turn, rng).T, form="%.3f")
        table += [f"{pose},{leg},{r}" for leg, r in zip(LEGS, read, strict=True)]
        sheet.append(f"{pose},{roll:.2f},{pitch:.2f},{yaw:.2f}")
    legs, body_log = write(tmp_path / "legs.csv", table), write(tmp_path / "body.csv", sheet)
    found = parts(legs, body_log, hang)
    assert set(found) == {"hang", "poses"}
    assert any("rotation_rpy_rad = [0, 0, 0]" in t for t in found["hang"].plan.robot)
    entries = found["poses"].plan.entries
    assert {"pose", "leg", "phase_rad", "body_roll_rad", "fz_n"} <= set(entries)
    assert entries["body_yaw_rad"].names["12"] == f"{float(sheet[-1].split(',')[3]):.10g}"
    assert not entries["pose"].names


def test_the_joint_that_swings_is_the_shaft_in_hangings_and_poses(tmp_path: Path) -> None:
    rng, paths = np.random.default_rng(2), list[Path]()
    names = [f"{leg}_{what}" for leg in LEGS for what in ("q1", "q2", *AXES)]
    for word, (roll, pitch) in HUNG.items():
        turn = Rotation.from_euler("xyz", [roll, pitch, 0.0], degrees=True)
        own = []
        for _ in LEGS:
            angle = 1.05 * np.sin(np.linspace(0, 2 * np.pi, 60)) + rng.normal(0, 1e-3, 60)
            knee = 0.87 + rng.normal(0, 1e-3, 60)
            own.append(np.column_stack([angle, knee, hung(turn, angle, rng)]))
        still = np.tile(np.radians([roll, pitch, 0.0]), (60, 1))
        body = rows(0.1 * np.arange(60), *still.T, *np.hstack(own).T, form="%.4f")
        head = ",".join(["t", "rolamento", "arfagem", "guinada", *names])
        paths.append(write(tmp_path / f"suspenso_{word}.csv", [head, *body]))
    sheet = [
        "postura,rolamento,arfagem,guinada," + ",".join(f"{x}_q{j}" for x in LEGS for j in "12")
    ]
    for pose in range(1, 13):
        angles = rng.uniform([-0.1, -0.1, -3.0], [0.1, 0.1, 3.0])
        joints = rng.uniform([-0.9, 0.8] * 4, [-0.4, 1.9] * 4)  # knees move more than hips
        read = stood(Rotation.from_euler("xyz", angles), rng).ravel()
        table = np.tile(read, (20, 1)) + rng.normal(0, 0.05, (20, 24))
        head = ",".join(["amostra", *(f"{leg}_{axis}" for leg in LEGS for axis in AXES)])
        body = rows(np.arange(1, 21), *table.T, form="%.4f")
        paths.append(write(tmp_path / f"postura_{pose:02d}.csv", [head, *body]))
        sheet.append(",".join([str(pose), *(f"{v:.4f}" for v in (*angles, *joints))]))
    found = parts(*paths, write(tmp_path / "resumo.csv", sheet))
    assert set(found) == {"hang", "poses"}
    column = found["hang"].plan.wide["dd"]["phase_rad"].column
    assert column is not None
    assert column.column == "DD_q1"
    entry = found["poses"].plan.wide["dd"]["phase_rad"]
    assert entry.names["12"] == f"{float(sheet[-1].split(',')[6]):.10g}"
    assert entry.unit == "rad"
    assert found["poses"].plan.entries["pose"].file_name


@pytest.mark.parametrize(("weighed", "role"), [(False, "hang"), (True, "weights")])
def test_numbers_of_six_axis_files_are_weights_where_forces_follow(
    tmp_path: Path, weighed: bool, role: str
) -> None:
    rng = np.random.default_rng(3)
    _, wrench, _ = wrist(rng, 9, 20)
    paths = []
    for i, own in enumerate(np.split(wrench, 9)):
        own[:, 2] = -9.8 * (i + 1) + rng.normal(0, 0.02, 20) if weighed else own[:, 2]
        body = rows(0.01 * np.arange(20), *own.T, form="%.4f")
        paths.append(write(tmp_path / f"essai_{i + 1}.csv", ["t,Fx,Fy,Fz,Mx,My,Mz", *body]))
    assert set(parts(*paths)) == {role}


def test_an_index_by_number_is_not_turned_into_a_row_per_sample(tmp_path: Path) -> None:
    rng, paths, index = np.random.default_rng(4), list[Path](), ["no;leg;gx;gy;gz"]
    for roll, pitch in HUNG.values():
        turn = Rotation.from_euler("xyz", [roll, pitch, 0.0], degrees=True)
        for leg in LEGS[:3]:
            angle = np.linspace(-1.0, 1.0, 30)
            body = rows(0.1 * np.arange(30), angle, *hung(turn, angle, rng).T, form="%.4f")
            paths.append(write(tmp_path / f"test_{len(paths) + 1:02d}.csv",
                               [f"t,angle,{','.join(AXES)}", *body]))  # fmt: skip
            down = turn.inv().apply([0.0, 0.0, -1.0])
            index.append(";".join([str(len(paths)), leg, *(f"{g:.3f}" for g in down)]))
    found = parts(*paths, write(tmp_path / "index.csv", index))
    assert set(found) == {"hang"}
    entries = found["hang"].plan.entries
    assert entries["leg"].names["05"] == LEGS[1]
    assert {"body_gravity_x", "phase_rad"} <= set(entries)


@pytest.mark.parametrize(("size", "unit"), [(1.0, "N*m"), (100.0, "N*cm"), (1000.0, "N*mm")])
def test_torques_without_a_unit_are_read_by_their_lever(
    tmp_path: Path, size: float, unit: str
) -> None:
    _, wrench, rot = wrist(np.random.default_rng(5))
    read = wrench * ([1.0] * 3 + [size] * 3)
    body = rows(0.02 * np.arange(len(read)), *rot.as_quat().T, *read.T, form="%.4f")
    path = write(tmp_path / "arm.csv", ["t,qx,qy,qz,qw,Fx,Fy,Fz,Mx,My,Mz", *body])
    entry = parts(path)["hang"].plan.entries["tx_nm"]
    assert entry.unit == unit
    assert (entry.sure == "guess") == (unit == "N*cm")


@pytest.mark.parametrize(
    ("turned_rad", "size", "unit", "said"),
    [(0.5, 1.0, "rad", True), (0.08, 180 / np.pi, "deg", True), (0.5, 180 / np.pi, "deg", True),
     (0.0, 1.0, "rad", False)],
)  # fmt: skip
def test_feet_turn_as_their_way_does(turned_rad: float, size: float, unit: str, said: bool) -> None:
    heading = turned_rad * np.linspace(0, 1, 2000) ** 2
    rng = np.random.default_rng(6)
    way = (np.cumsum(1e-3 * np.exp(1j * heading)) + 0.002 * rng.normal(size=2000)).astype(complex)
    angles = {a: 0.002 * rng.normal(size=2000) for a in ("roll", "pitch")}
    columns = {
        a: ColumnGuess(a, NameGuess("angle", a), None, "likely", "", size * v)
        for a, v in {**angles, "yaw": heading}.items()
    }
    found, why = angle_unit(Axes("sole_", "", columns), way)
    assert (found, bool(why)) == (unit, said)


@pytest.mark.parametrize(("lines", "unit"), [
    (["hidari_ashi_ / migi_ashi_ pose of the soles in the world [mm, deg]"], "deg"),
    (["trunk: tilt in deg", "roll, pitch, yaw in rad"], "rad"), (["Gierwinkel in Grad"], "deg"),
    (["roll/pitch/yaw: ±3°, at 24 °C"], "deg"), (["yaw at 2 rad/s, 20 °C"], ""),
    (["ten wedges of 5 deg"], ""), (["yaw in rad (the sheet has deg)"], ""),
])  # fmt: skip
def test_notes_say_the_unit_of_small_angles(lines: list[str], unit: str) -> None:
    small = np.random.default_rng(8).normal(0, 0.05, 500)
    columns = {a: ColumnGuess(a, NameGuess("angle", a), None, "likely", "", small)
               for a in ("roll", "pitch", "yaw")}  # fmt: skip
    found, why = angle_unit(Axes("hidari_ashi_", "", columns), np.zeros(500, complex), lines)
    assert (found if why else "") == unit

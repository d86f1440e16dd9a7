"""Which way gravity pulls on a transducer, and how it is turned in its robot, by the forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.attitudes import attitude_of, named_orientation, turns
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.hint import accepted, hint
from footcal_cli.sniff.holds import blank_loads
from footcal_cli.sniff.mounts import mounts_of
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.plan import Entry

WEIGHT_N = 9.0
ATTITUDES = Rotation.random(14, random_state=np.random.default_rng(1))
DOWN = ATTITUDES.inv().apply([0.0, 0.0, -1.0])


def _log(folder: Path, names: str, table: FloatArray) -> FileGuess:
    log = folder / "a.csv"
    np.savetxt(log, np.repeat(table, 4, axis=0), "%.8f", ",", header=names, comments="")
    return numbered(guess_file(log))


def _force(seed: int = 2) -> FloatArray:
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, 0.01, (14, 3))
    return np.asarray(np.repeat(WEIGHT_N * DOWN + [1.0, -2.0, 3.0] + noise, 4, axis=0))


QUATERNION = ATTITUDES.as_quat()
FIRST = np.roll(QUATERNION, 1, axis=1)
ROTATION = ATTITUDES.as_matrix()
POSE = np.concatenate([ROTATION, np.full((14, 3, 1), 0.4)], axis=2)
WAYS = {
    "quaternion": ("qx,qy,qz,qw", QUATERNION),
    "scalar first, by number": ("q1,q2,q3,q4", FIRST),
    "conjugate": ("qx,qy,qz,qw", ATTITUDES.inv().as_quat()),
    "matrix": (",".join(f"r{i}{j}" for i in "123" for j in "123"), ROTATION.reshape(14, 9)),
    "pose of twelve": (",".join(f"T{i}{j}" for i in "012" for j in "0123"), POSE.reshape(14, 12)),
    "pose of twelve, by columns": (
        ",".join(f"T_{i}" for i in range(12)), POSE.transpose(0, 2, 1).reshape(14, 12),
    ),
    "W P R": ("W(deg),P(deg),R(deg)", ATTITUDES.as_euler("xyz", degrees=True)),
    "A B C": ("A (deg),B (deg),C (deg)", ATTITUDES.as_euler("ZYX", degrees=True)),
    "heading, pitch, bank": (
        "heading_deg,pitch_deg,bank_deg", ATTITUDES.as_euler("ZYX", degrees=True),
    ),
    "rotation vector": ("rx,ry,rz", ATTITUDES.as_rotvec()),
    "down": ("gx,gy,gz", DOWN),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_write_an_attitude_is_told_by_the_forces(tmp_path: Path, way: str) -> None:
    names, table = WAYS[way]
    log = _log(tmp_path, f"Fx,Fy,Fz,{names}", np.hstack([_force()[::4], table]))
    found = attitude_of(log, _force())
    assert found is not None
    assert found.explains
    assert not found.reacts


def test_forces_of_another_attitude_are_no_weight(tmp_path: Path) -> None:
    other = Rotation.random(14, random_state=np.random.default_rng(9)).as_quat()
    log = _log(tmp_path, "Fx,Fy,Fz,qx,qy,qz,qw", np.hstack([_force()[::4], other]))
    found = attitude_of(log, _force())
    assert found is not None
    assert found.explains is False


def test_orientations_that_say_what_points_up_are_turned_round() -> None:
    words = ["x", "y", "z"]
    down = np.vstack([np.eye(3), -np.eye(3)])
    names = [f"{a}_down" for a in words] + [f"{a}_up" for a in words]
    plain = named_orientation(names, Entry(), WEIGHT_N * down)
    turned = named_orientation(names, Entry(), -WEIGHT_N * down)
    assert plain is not None
    assert turned is not None
    assert plain.entries["orientation"].names["x_down"] == "+x"
    assert turned.entries["orientation"].names["x_down"] == "-x"
    assert named_orientation(["x_up", "tare"], Entry(), down[:2]) is None


def test_a_body_that_hardly_turns_says_nothing() -> None:
    assert turns(DOWN)
    assert not turns(np.tile([0.0, 0.0, -1.0], (14, 1)))


def test_how_a_transducer_is_turned_in_its_robot(tmp_path: Path) -> None:
    """Force = w Rᵀ g: the rotation R of the drawing is found, to whole right angles."""
    mounted = Rotation.from_euler("xyz", [90, 0, 90], degrees=True)
    force = np.repeat(mounted.inv().apply(WEIGHT_N * DOWN), 4, axis=0)
    log = _log(tmp_path, "Fx,Fy,Fz,qx,qy,qz,qw", np.hstack([force[::4], QUATERNION]))
    found = mounts_of(log, {"leg": force})
    assert found is not None
    assert found.hang
    np.testing.assert_allclose(found.rotation["leg"], mounted.as_matrix(), atol=1e-9)


def test_a_refused_log_is_told_what_it_looks_like(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("load_kg,raw\n" + "".join(f"{i % 4},{7000 + 90 * (i % 4)}\n" for i in range(12)))
    found = hint(log)
    assert found is not None
    assert "known weights" in found[0]
    assert found[1] == accepted("weights")
    assert hint(tmp_path / "none.csv") is None


def test_the_holds_of_a_recording_stand_in_the_blank() -> None:
    noise = np.random.default_rng(5).normal(0, 2, 480)
    blank = blank_loads(np.arange(480) / 20, np.repeat([8_000.0, 9_000.0, 7_500.0], 160) + noise)
    assert "3 holds were found, at readings of" in "\n".join(blank.lines)

"""``footcal convert``: units and structure of each kind of file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from tests.cli import foreign_logs as foreign
from tests.conftest import Run

ROOT = Path(__file__).resolve().parent.parent.parent


# ------------------------------------------------------------------ laboratories
def test_opensim_forces_and_angles_get_their_units(tmp_path: Path, run: Run) -> None:
    forces = tmp_path / "grf.mot"
    forces.write_text(
        "subject\nversion=1\nnRows=2\nnColumns=5\ninDegrees=yes\nendheader\n"
        "time\tground_force_vx\tground_force_vy\tground_force_px\tground_torque_y\n"
        "0.0\t1.5\t700.0\t0.25\t0.125\n0.01\t2.5\t701.0\t0.26\t0.25\n"
    )
    angles = tmp_path / "ik.mot"
    angles.write_text("ik\nnRows=1\nnColumns=3\ninDegrees=yes\nendheader\n"
                      "time\tpelvis_tx\tknee_angle_r\n0.5\t0.9\t45.0\n")  # fmt: skip
    answer = run("convert", forces, angles, "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    written = pd.read_parquet(tmp_path / "out/grf.parquet")
    assert written.to_dict("list") == {
        "time_s": [0.0, 0.01], "ground_force_vx_n": [1.5, 2.5], "ground_force_vy_n": [700.0, 701.0],
        "ground_force_px_m": [0.25, 0.26], "ground_torque_y_nm": [0.125, 0.25],
    }  # fmt: skip
    written = pd.read_parquet(tmp_path / "out/ik.parquet")
    assert written.to_dict("list") == {
        "time_s": [0.5], "pelvis_tx_m": [0.9], "knee_angle_r_deg": [45.0]
    }  # fmt: skip


def test_a_force_plate_of_a_c3d_agrees_with_its_publishers_export(
    real_data: Path, tmp_path: Path, run: Run
) -> None:
    source = real_data / "loadsol-insoles/test_poids.c3d"
    answer = run("convert", source, "--topic", "plate_4", "--out", tmp_path / "plate.parquet")
    assert answer.exit_code == 0, answer.err
    plate = pd.read_parquet(tmp_path / "plate.parquet").iloc[::5].reset_index(drop=True)
    theirs = pd.read_csv(real_data / "loadsol-insoles/test_poids_forceplate.csv")  # counts from 0
    rounding = 0.5001e-3  # they print three decimals of N and mm
    np.testing.assert_allclose(plate["time_s"], theirs["t_s"], atol=1e-9)
    for axis in "xyz":
        off = plate[f"force_{axis}_n"] - theirs[f"p3_f{axis}_N"]
        assert off.abs().max() <= rounding
    # the CoP lies where the moment about the plate's centre (0.9, 0.45) m has no part in x and y
    loaded = plate[plate["force_z_n"] > 50.0]
    lever_x, lever_y = loaded["cop_x_m"] - 0.9, loaded["cop_y_m"] - 0.45
    np.testing.assert_allclose(-lever_x * loaded["force_z_n"], loaded["moment_y_nm"], atol=1e-3)
    np.testing.assert_allclose(lever_y * loaded["force_z_n"], loaded["moment_x_nm"], atol=1e-3)
    for axis in "xy":
        off = 1e3 * plate[f"cop_{axis}_m"] - theirs[f"p3_cop{axis}_mm"]
        assert (off.isna() == theirs[f"p3_cop{axis}_mm"].isna()).all()
        assert off.abs().max() <= rounding


def test_channels_of_a_c3d_keep_their_unit_as_suffix(tmp_path: Path, run: Run) -> None:
    answer = run("convert", foreign.write_c3d(tmp_path / "trial.c3d"), "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    analog = pd.read_parquet(tmp_path / "out/analog.parquet")
    np.testing.assert_allclose(analog["time_s"], 0.005 * np.arange(6))
    assert analog["Fz1_n"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert analog["Mx1_nmm"].tolist() == [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]
    points = pd.read_parquet(tmp_path / "out/points.parquet")
    assert points["heel.y_mm"].tolist() == [20.0, 20.0, 20.0]


def test_a_workspace_structure_without_samples_holds_no_columns(tmp_path: Path, run: Run) -> None:
    """It ended with exit code 70."""
    signals = {"values": np.zeros((0, 2)), "label": "load,raw"}
    savemat(tmp_path / "empty.mat", {"out": {"time": np.zeros(0), "signals": signals}})
    answer = run("convert", tmp_path / "empty.mat", "--out", tmp_path / "out")
    assert answer.exit_code == 3, answer.err
    assert "nothing in it can be written as columns" in answer.err


# ------------------------------------------------------------------ arrays
def test_nested_structs_become_tables_by_their_length(tmp_path: Path, run: Run) -> None:
    content = {
        "log": {"t": np.arange(4.0), "ft": {"force": np.arange(12.0).reshape(4, 3)}},
        "weights": {"load": np.array([1.0, 2.0])},
        "fs": 200.0,
    }
    savemat(tmp_path / "bench.mat", content)
    answer = run("convert", tmp_path / "bench.mat", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    log = pd.read_parquet(tmp_path / "out/log.parquet")
    assert log["t"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert log["ft.force_1"].tolist() == [1.0, 4.0, 7.0, 10.0]
    assert pd.read_parquet(tmp_path / "out/weights.parquet")["load"].tolist() == [1.0, 2.0]
    assert "fs (one value)" in answer.out


def test_units_that_hdf5_states_become_suffixes(tmp_path: Path, run: Run) -> None:
    with h5py.File(tmp_path / "rig.h5", "w") as file:
        file["force"] = np.array([1.0, 2.0, 3.0])
        file["force"].attrs["units"] = "kN"
        file["mode"] = np.array([1, 2, 3])
    answer = run("convert", tmp_path / "rig.h5", "--out", tmp_path / "rig.parquet")
    assert answer.exit_code == 0, answer.err
    assert pd.read_parquet(tmp_path / "rig.parquet").to_dict("list") == {
        "force_kn": [1.0, 2.0, 3.0], "mode": [1, 2, 3]
    }  # fmt: skip


def test_json_lines_may_nest_and_leave_numbers_out(tmp_path: Path, run: Run) -> None:
    (tmp_path / "serial.jsonl").write_text(
        '{"t": 0, "cell": {"fl": 8300000}, "note": "zero"}\n'
        '{"t": 0.5, "cell": {"fl": 8299999, "fr": 7}, "note": "1 kg"}\n'
    )
    answer = run("convert", tmp_path / "serial.jsonl", "--out", tmp_path / "serial.parquet")
    assert answer.exit_code == 0, answer.err
    written = pd.read_parquet(tmp_path / "serial.parquet")
    assert written["t"].tolist() == [0.0, 0.5]
    assert written["cell.fl"].tolist() == [8300000, 8299999]
    np.testing.assert_array_equal(written["cell.fr"], [np.nan, 7.0])
    assert written["note"].tolist() == ["zero", "1 kg"]


def test_a_json_list_is_read_as_its_objects(tmp_path: Path, run: Run) -> None:
    objects = [{"weight_kg": 0.5, "raw": 8}, {"weight_kg": 1.0, "raw": 9}]
    (tmp_path / "all.json").write_text(json.dumps(objects, indent=2))
    answer = run("convert", tmp_path / "all.json", "--out", tmp_path / "all.parquet")
    assert answer.exit_code == 0, answer.err
    assert pd.read_parquet(tmp_path / "all.parquet").to_dict("records") == objects


def write_standard(path: Path) -> Path:
    """Messages of the standard packages, two of each."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    point = types["geometry_msgs/msg/Point"]
    nine, thirty_six = np.zeros(9), np.zeros(36)

    def header(i: int) -> Any:
        stamp = types["builtin_interfaces/msg/Time"](10, 20_000_000 * i)
        return types["std_msgs/msg/Header"](stamp, "foot")

    def pose(i: int) -> Any:
        return types["geometry_msgs/msg/Pose"](
            point(1.0, 2.0, 3.0 + i), quaternion(0.0, 0.0, 0.0, 1.0)
        )

    def layout() -> Any:
        return types["std_msgs/msg/MultiArrayLayout"]([], 0)

    def of(name: str, *fields: Any) -> Any:
        return types[name](*fields)

    ft, imu = "geometry_msgs/msg/WrenchStamped", "sensor_msgs/msg/Imu"
    joints, odom = "sensor_msgs/msg/JointState", "nav_msgs/msg/Odometry"
    placed, moved = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/TransformStamped"
    counts, volts = "std_msgs/msg/Int32MultiArray", "std_msgs/msg/Float64MultiArray"
    turned = quaternion(0.0, 0.0, 0.0, 1.0)
    wrench, twist = "geometry_msgs/msg/Wrench", "geometry_msgs/msg/Twist"
    sure_pose, sure_twist = (f"geometry_msgs/msg/{x}WithCovariance" for x in ("Pose", "Twist"))
    transform = "geometry_msgs/msg/Transform"
    made: dict[str, tuple[str, Callable[[int], Any]]] = {
        "/ft": (ft, lambda i: of(
            ft, header(i), of(wrench, vector(1.0, 2.0, 3.0 + i), vector(4.0, 5.0, 6.0)))),
        "/imu": (imu, lambda i: of(
            imu, header(i), turned, nine, vector(0.1, 0.2, 0.3), nine, vector(0.0, 0.0, 9.8 + i),
            nine)),
        "/joints": (joints, lambda i: of(
            joints, header(i), ["hip", "knee"][:: 1 - 2 * i], np.array([0.5, 1.5][:: 1 - 2 * i]),
            np.zeros(2), np.zeros(0))),
        "/odom": (odom, lambda i: of(
            odom, header(i), "base", of(sure_pose, pose(i), thirty_six),
            of(sure_twist, of(twist, vector(0.4, 0.0, 0.0), vector(0.0, 0.0, 0.1)), thirty_six))),
        "/pose": (placed, lambda i: of(placed, header(i), pose(i))),
        "/tf_foot": (moved, lambda i: of(
            moved, header(i), "sole", of(transform, vector(7.0, 8.0, 9.0), turned))),
        "/fsr": (counts, lambda i: of(
            counts, layout(), np.array([8_300_000 + i, -5], dtype=np.int32))),
        "/volts": (volts, lambda i: of(volts, layout(), np.array([0.25, 0.5 + i]))),
        "/load": ("std_msgs/msg/Float64", lambda i: of("std_msgs/msg/Float64", 12.5 + i)),
        "/words": ("std_msgs/msg/Empty", lambda _i: of("std_msgs/msg/Empty")),
    }  # fmt: skip
    with Writer2(path, version=9) as bag:
        for topic, (name, make) in made.items():
            link = bag.add_connection(topic, name, typestore=store)
            for i in range(2):
                bag.write(link, 11_000_000_000 + i, store.serialize_cdr(make(i), name))
    return path


EXPECTED: dict[str, dict[str, list[float]]] = {
    "ft": {"wrench.force.z_n": [3.0, 4.0], "wrench.torque.y_nm": [5.0, 5.0]},
    "imu": {"linear_acceleration.z_mps2": [9.8, 10.8], "angular_velocity.x_radps": [0.1, 0.1],
            "orientation.w": [1.0, 1.0]},
    "joints": {"position.hip": [0.5, 0.5], "position.knee": [1.5, 1.5]},
    "odom": {"pose.pose.position.z_m": [3.0, 4.0], "twist.twist.linear.x_mps": [0.4, 0.4]},
    "pose": {"pose.position.x_m": [1.0, 1.0], "pose.orientation.w": [1.0, 1.0]},
    "tf_foot": {"transform.translation.y_m": [8.0, 8.0]},
    "fsr": {"data_0": [8_300_000, 8_300_001], "data_1": [-5, -5]},
    "volts": {"data_1": [0.5, 1.5]},
    "load": {"data": [12.5, 13.5]},
}  # fmt: skip


def test_standard_messages_become_columns_with_their_units(tmp_path: Path, run: Run) -> None:
    answer = run("convert", write_standard(tmp_path / "bag"), "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    for topic, columns in EXPECTED.items():
        written = pd.read_parquet(tmp_path / "out" / f"{topic}.parquet")
        for name, values in columns.items():
            assert written[name].tolist() == values, (topic, name)
        headed = topic not in {"fsr", "volts", "load"}
        assert written["time_ns"].tolist() == (
            [10_000_000_000, 10_020_000_000] if headed else [11_000_000_000, 11_000_000_001]
        )
    # joints change places in the second message: they go by name; an array of counts stays whole
    assert pd.read_parquet(tmp_path / "out/fsr.parquet")["data_0"].dtype == np.int64
    assert "log time (no header stamps)" in answer.out
    assert "left out of /imu: orientation_covariance" in answer.out
    assert not (tmp_path / "out/words.parquet").exists()


def test_list_tells_what_is_inside_and_writes_nothing(tmp_path: Path, run: Run) -> None:
    bag = write_standard(tmp_path / "bag")
    answer = run("convert", bag, "--list", "--out", tmp_path / "out")
    assert answer.exit_code == 0, answer.err
    assert "/ft  geometry_msgs/msg/WrenchStamped  2 rows" in answer.out
    assert "wrench.force.x_n" in answer.out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bag"]

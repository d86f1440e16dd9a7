"""``footcal export``: what the consumer computes from its file is the wrench worked out by hand."""

from __future__ import annotations

import json
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.io import loadmat
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.exporters.contract import number
from footcal_cli.records.files import write_record
from footcal_cli.records.results import EffectRecord, ParameterRecord, ParametersRecord
from tests.conftest import Run

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
OFFSET = np.array([1.0, -2.0, 3.0, 0.125, -0.25, 0.5])
WEIGHT_N = 10.0
COM_M = (0.1, 0.0, 0.0)
# gravity along −z: force (0, 0, −10), torque (0.1, 0, 0) × (0, 0, −10) = (0, 1, 0)
HANGING = np.array([0.0, 0.0, -10.0, 0.0, 1.0, 0.0])
PUSH = np.array([5.0, 0.0, 20.0, 0.0, -1.5, 0.25])
QUARTER = np.pi / 2


def parameter(value: float, unit: str = "N") -> ParameterRecord:
    return ParameterRecord(value=value, sd=0.01, unit=unit, status=Status.ESTIMATED)


def transducer(
    name: str = "ft", *, mounted: bool = False, swing_m: float = 0.0
) -> dict[str, ParameterRecord]:
    """One transducer; mounted means turned by a quarter about z and moved by 20 mm along x."""
    found = {f"{name}.offset_{a}": parameter(o) for a, o in zip(AXES, OFFSET, strict=True)}
    found[f"{name}.weight"] = parameter(WEIGHT_N)
    for axis, mean in zip("xyz", COM_M, strict=True):
        found[f"{name}.com_{axis}_mean"] = parameter(mean, "m")
        found[f"{name}.com_{axis}_sin"] = parameter(swing_m if axis == "y" else 0.0, "m")
        found[f"{name}.com_{axis}_cos"] = parameter(0.0, "m")
    if mounted:
        for axis, turn, move in zip("xyz", (0.0, 0.0, QUARTER), (0.02, 0.0, 0.0), strict=True):
            found[f"{name}.mount_rot_{axis}"] = parameter(turn, "rad")
            found[f"{name}.mount_pos_{axis}"] = parameter(move, "m")
    return found


def cells() -> dict[str, ParameterRecord]:
    return {
        "left_fl.scale": parameter(-3.4e-5, "N/count"), "left_fl.bias": parameter(283.1),
        "left_fr.scale": parameter(-3.5e-5, "N/count"), "left_fr.bias": parameter(284.2),
    }  # fmt: skip


def write(
    folder: Path,
    parameters: dict[str, ParameterRecord],
    effects: tuple[EffectRecord, ...] = (),
    rejected: tuple[str, ...] = (),
) -> Path:
    record = ParametersRecord(
        command="hang-calib", created="2026-01-01T00:00:00+00:00", robot="rig",
        gravity_mps2=9.80665, sign_convention="reading = applied + offset",
        frame="transducer", expressed_at="its origin",
        parameters=parameters, effects=effects, rejected_because=rejected,
    )  # fmt: skip
    path = folder / "parameters.json"
    write_record(record, path)
    return path


def recipe(folder: Path) -> Path:
    """The transducer sits at (0.3, 0, 0.1) in its body, nominally unturned."""
    path = folder / "robot.toml"
    path.write_text("[robot]\nname = 'rig'\n[robot.legs.ft]\nposition_m = [0.3, 0.0, 0.1]\n")
    return path


# ------------------------------------------------------------------ KTH
def test_kth_compensation_leaves_what_pushes(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "ft_calib.yaml"
    answer = run("export", write(tmp_path, transducer()), "--to", "kth-yaml",
                 "--sensor", "ft=wrist_ft", "--out", out)  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert not answer.err
    file = yaml.safe_load(out.read_text())
    # the node: compensated = reading − bias − [m a; r × m a], a = gravity in the transducer's frame
    gravity = np.array([0.0, 0.0, -9.80665])
    force = file["gripper_mass"] * gravity
    weight = np.concatenate([force, np.cross(file["gripper_com_pose"][:3], force)])
    reading = PUSH + HANGING + OFFSET
    np.testing.assert_allclose(reading - file["bias"] - weight, PUSH, atol=1e-12)
    assert file["gripper_com_pose"][3:] == [0.0, 0.0, 0.0]
    assert file["gripper_com_frame_id"] == "wrist_ft"
    assert "pointing down" in out.read_text()


def test_a_com_that_swings_is_said_where_the_file_holds_its_mean(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "ft.yaml"
    answer = run("export", write(tmp_path, transducer(swing_m=0.03)), "--to", "kth-yaml",
                 "--out", out)  # fmt: skip
    assert answer.exit_code == 0, answer.err
    assert "moves by 30.0 mm" in answer.err
    assert "# WARNING: the CoM below ft moves by 30.0 mm" in out.read_text()


# ------------------------------------------------------------------ mc_rtc
def mc_rtc_removes(path: Path, sensor_at_m: FloatArray, gravity_mps2: float) -> FloatArray:
    """What mc_rtc takes off a reading, [force; torque], body level: its formula, 13 numbers."""
    mass, *rest = [float(word) for word in path.read_text().split()[:13]]
    rpy, com_parent_m, offset = np.array(rest[:3]), np.array(rest[3:6]), np.array(rest[6:])
    rot_body_from_real = Rotation.from_euler("xyz", rpy).as_matrix()  # fixed axes, as URDF
    down = rot_body_from_real.T @ np.array([0.0, 0.0, -mass * gravity_mps2])
    lever = rot_body_from_real.T @ (com_parent_m - sensor_at_m)
    torque, force = offset[:3] + np.cross(lever, down), offset[3:] + down
    return np.concatenate([force, torque])


@pytest.mark.parametrize("mounted", [False, True])
def test_mc_rtc_takes_offset_and_weight_off(mounted: bool, tmp_path: Path, run: Run) -> None:
    out = tmp_path / "calib_data.ft"
    answer = run("export", write(tmp_path, transducer(mounted=mounted)), "--to", "mc_rtc",
                 "--recipe", recipe(tmp_path), "--out", out)  # fmt: skip
    assert answer.exit_code == 0, answer.err
    removed = mc_rtc_removes(out, np.array([0.3, 0.0, 0.1]), 9.80665)
    # a turn about z leaves the weight along −z and the CoM where it is in the transducer's axes
    np.testing.assert_allclose(removed, HANGING + OFFSET, atol=1e-12)
    numbers = [float(word) for word in out.read_text().split()[:13]]
    assert numbers[3] == pytest.approx(QUARTER if mounted else 0.0)
    assert numbers[4:7] == pytest.approx([0.3, 0.1, 0.1] if mounted else [0.4, 0.0, 0.1])
    # mc_rtc cannot move a sensor
    assert ("(20.00, 0.00, 0.00) mm" in answer.err) == mounted
    # its reader fails where the last number ends the file
    assert out.read_text().splitlines()[13].startswith("# ")


def test_mc_rtc_without_the_nominal_pose_is_refused(tmp_path: Path, run: Run) -> None:
    answer = run("export", write(tmp_path, transducer()), "--to", "mc_rtc",
                 "--out", tmp_path / "c")  # fmt: skip
    assert answer.exit_code == 2
    assert "--recipe" in answer.err
    assert not (tmp_path / "c").exists()


# ------------------------------------------------------------------ ros2_control
def test_ros2_control_adds_its_offset_and_multiplies_afterwards(tmp_path: Path, run: Run) -> None:
    gains = {f"ft.gain_{axis}": parameter(0.25 if axis == "fz" else 0.0, "1") for axis in AXES}
    effects = (EffectRecord(effect="scale_matrix", owners={"ft": ("ft",)}),)
    source = write(tmp_path, transducer() | gains, effects)
    out = tmp_path / "ros2.yaml"
    answer = run("export", source, "--to", "ros2_control", "--out", out)
    assert answer.exit_code == 0, answer.err
    node = yaml.safe_load(out.read_text())["force_torque_sensor_broadcaster"]["ros__parameters"]
    assert node["sensor_name"] == node["frame_id"] == "ft"

    def six(key: str) -> FloatArray:
        return np.array([node[key][kind][axis] for kind in ("force", "torque") for axis in "xyz"])

    shown = PUSH * np.array([1.0, 1.0, 1.25, 1.0, 1.0, 1.0]) + OFFSET
    np.testing.assert_allclose((shown + six("offset")) * six("multiplier"), PUSH, atol=1e-12)
    assert "the weight below ft stays" in answer.err


# ------------------------------------------------------------------ wholeBodyDynamics
def numbers_of(root: ET.Element, group: str, name: str) -> FloatArray:
    param = root.find(f"group[@name='{group}']/param[@name='{name}']")
    assert param is not None
    assert param.text is not None
    return np.array([float(x) for x in param.text.strip("()").split(",")])


def test_wbd_matrix_and_offset_give_the_wrench_in_the_nominal_frame(
    tmp_path: Path, run: Run
) -> None:
    coupling = {"ft.coupling_fx_fz": parameter(0.5, "1")}
    effects = (EffectRecord(effect="cross_coupling", owners={"ft": ("ft",)}),)
    source = write(tmp_path, transducer(mounted=True) | coupling, effects)
    answer = run("export", source, "--to", "wbd-xml", "--out", tmp_path / "wbd.xml")
    assert answer.exit_code == 0, answer.err
    assert not answer.err
    root = ET.parse(tmp_path / "wbd.xml").getroot()
    matrix = numbers_of(root, "FT_SECONDARY_CALIBRATION", "ft").reshape(6, 6)
    offset = numbers_of(root, "FT_OFFSET", "ft")
    # 10 N along nominal y at the real origin, which lies 20 mm along x: about the nominal origin
    # (0.02, 0, 0) × (0, 10, 0) = (0, 0, 0.2). Turned by a quarter, the transducer sees them along
    # its x; 4 N along z add half of themselves to its fx.
    nominal = np.array([0.0, 10.0, 4.0, 0.0, -0.02 * 4.0, 0.2])
    seen = np.array([10.0 + 0.5 * 4.0, 0.0, 4.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(matrix @ (seen + OFFSET) - offset, nominal, atol=1e-12)


# ------------------------------------------------------------------ URDF
def test_urdf_places_the_transducer_where_it_really_sits(tmp_path: Path, run: Run) -> None:
    answer = run("export", write(tmp_path, transducer(mounted=True)), "--to", "urdf",
                 "--recipe", recipe(tmp_path), "--out", tmp_path / "ft.urdf")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    origin = ET.parse(tmp_path / "ft.urdf").getroot().find("joint/origin")
    assert origin is not None
    assert [float(x) for x in origin.attrib["xyz"].split()] == pytest.approx([0.32, 0.0, 0.1])
    assert [float(x) for x in origin.attrib["rpy"].split()] == pytest.approx([0.0, 0.0, QUARTER])


def test_a_reader_of_urdf_finds_the_transducer(tmp_path: Path, run: Run) -> None:
    """A description without a name or links is none: no reader takes it."""
    pinocchio = pytest.importorskip("pinocchio")
    run("export", write(tmp_path, transducer(mounted=True)), "--to", "urdf",
        "--recipe", recipe(tmp_path), "--out", tmp_path / "ft.urdf")  # fmt: skip
    model = pinocchio.buildModelFromUrdf(str(tmp_path / "ft.urdf"))
    assert model.name == "rig"
    placed = model.frames[model.getFrameId("ft")].placement
    np.testing.assert_allclose(placed.translation, [0.32, 0.0, 0.1], atol=1e-12)
    turned = Rotation.from_euler("z", QUARTER).as_matrix()
    np.testing.assert_allclose(placed.rotation, turned, atol=1e-12)


@pytest.mark.parametrize("value", [1e-5, -2e-7, 3e20, 1e16, 0.0, 1.25e-6, -4.0])
def test_a_number_is_one_to_readers_of_yaml(value: float) -> None:
    """YAML 1.1 takes `1e-05` for a text; rosparam then gives the node a string."""
    assert yaml.safe_load(f"bias: [{number(value)}]") == {"bias": [value]}
    assert json.loads(number(value)) == value


def test_a_mounting_that_was_not_calibrated_is_no_urdf(tmp_path: Path, run: Run) -> None:
    answer = run("export", write(tmp_path, transducer()), "--to", "urdf",
                 "--recipe", recipe(tmp_path), "--out", tmp_path / "ft.urdf")  # fmt: skip
    assert answer.exit_code == 2
    assert "pose-calib" in answer.err


# ------------------------------------------------------------------ C
def test_a_c_program_with_the_header_prints_the_force(tmp_path: Path, run: Run) -> None:
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("no gcc")
    out = tmp_path / "calibration.h"
    source = write(tmp_path, cells() | transducer(mounted=True))
    assert run("export", source, "--to", "c-header", "--out", out).exit_code == 0
    program = tmp_path / "main.c"
    seen = ", ".join(str(x) for x in np.array([10.0, 0.0, 4.0, 0.0, 0.0, 0.0]) + OFFSET)
    program.write_text(
        '#include <stdio.h>\n#include "calibration.h"\nint main(void) {\n'
        f"    const double reading[6] = {{{seen}}};\n    double wrench[6];\n"
        "    footcal_wrench(&footcal_transducers[FOOTCAL_TRANSDUCER_FT], reading, wrench);\n"
        '    printf("%.17g\\n", footcal_force_n(&footcal_cells[FOOTCAL_CELL_LEFT_FR], 8.0e6));\n'
        '    for (int i = 0; i < 6; ++i) printf("%.17g\\n", wrench[i]);\n    return 0;\n}\n'
    )
    built = tmp_path / "main"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]
    subprocess.run([compiler, *flags, "-o", built, program], check=True)
    printed = subprocess.run([built], check=True, capture_output=True, text=True).stdout.split()
    # −3.5e-5 · 8e6 + 284.2 = 4.2 N; the wrench as worked out for wholeBodyDynamics, uncoupled
    expected = [4.2, 0.0, 10.0, 4.0, 0.0, -0.08, 0.2]
    assert [float(word) for word in printed] == pytest.approx(expected, abs=1e-9)


# ------------------------------------------------------------------ MATLAB
def test_a_mat_file_holds_cells_and_transducers(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "calibration.mat"
    source = write(tmp_path, cells() | transducer())
    assert run("export", source, "--to", "matlab", "--out", out).exit_code == 0
    content = loadmat(out, squeeze_me=True, struct_as_record=False)
    assert content["cells"].left_fl.scale == -3.4e-5
    assert content["cells"].left_fl.bias == 283.1
    np.testing.assert_array_equal(content["transducers"].ft.offset, OFFSET)
    np.testing.assert_array_equal(content["transducers"].ft.matrix, np.eye(6))


def test_a_matlab_function_has_the_same_numbers(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "footcal_calibration.m"
    source = write(tmp_path, cells() | transducer())
    assert run("export", source, "--to", "matlab", "--out", out).exit_code == 0
    lines = out.read_text().splitlines()
    assert lines[0] == "function calibration = footcal_calibration()"
    assert "calibration.cells.left_fr.bias = 284.2; % N" in lines
    offset = next(line for line in lines if ".offset = " in line)
    inside = offset.partition("[")[2].partition("]")[0]
    assert [float(x) for x in inside.split(";")] == OFFSET.tolist()


# ------------------------------------------------------------------ refusals and losses
@pytest.mark.parametrize("target", ["kth-yaml", "mc_rtc", "ros2_control", "wbd-xml", "urdf"])
def test_load_cells_do_not_go_where_wrenches_belong(target: str, tmp_path: Path, run: Run) -> None:
    answer = run("export", write(tmp_path, cells()), "--to", target, "--out", tmp_path / "f")
    assert answer.exit_code == 2
    assert "load cells (left_fl, left_fr)" in answer.err
    assert not (tmp_path / "f").exists()


def test_a_rejected_calibration_is_not_passed_on(tmp_path: Path, run: Run) -> None:
    source = write(tmp_path, cells(), rejected=("RMSE 0.4 N exceeds 0.2 N",))
    answer = run("export", source, "--to", "c-header", "--out", tmp_path / "f.h")
    assert answer.exit_code == 2
    assert "RMSE 0.4 N" in answer.err
    assert not (tmp_path / "f.h").exists()


def test_an_effect_that_the_file_cannot_hold_is_said_twice(tmp_path: Path, run: Run) -> None:
    bent = {"left_fl.curvature": parameter(0.1)}
    effects = (EffectRecord(effect="nonlinearity", owners={"left_fl": ("left_fl",)}),)
    out = tmp_path / "f.h"
    answer = run(
        "export", write(tmp_path, cells() | bent, effects), "--to", "c-header", "--out", out
    )
    assert answer.exit_code == 0, answer.err
    assert "warning: nonlinearity of left_fl is not in this file" in answer.err
    assert "WARNING: nonlinearity of left_fl" in out.read_text()
    # the other cell is not bent
    answer = run("export", tmp_path / "parameters.json", "--to", "c-header", "--sensor", "left_fr",
                 "--out", out, "--overwrite")  # fmt: skip
    assert answer.exit_code == 0
    assert not answer.err


def test_one_file_of_one_transducer_asks_which(tmp_path: Path, run: Run) -> None:
    both = transducer("fl") | transducer("fr")
    source = write(tmp_path, both)
    answer = run("export", source, "--to", "kth-yaml", "--out", tmp_path / "f.yaml")
    assert answer.exit_code == 2
    assert "--sensor" in answer.err
    answer = run(
        "export", source, "--to", "kth-yaml", "--sensor", "fr", "--out", tmp_path / "f.yaml"
    )
    assert answer.exit_code == 0, answer.err


def test_a_foot_takes_the_weight_below_from_the_recipe(tmp_path: Path, run: Run) -> None:
    offsets = {name: p for name, p in transducer("left").items() if ".offset_" in name}
    source = write(tmp_path, offsets)
    refused = run("export", source, "--to", "kth-yaml", "--out", tmp_path / "f.yaml")
    assert refused.exit_code == 2
    assert "weight_below_n" in refused.err
    robot = tmp_path / "robot.toml"
    robot.write_text(
        "[robot.feet.left]\ntransducer_position_m = [0.0, 0.0, 0.05]\nweight_below_n = 9.80665\n"
        "com_below_m = [0.0, 0.0, -0.02]\n"
    )
    answer = run("export", source, "--to", "kth-yaml", "--recipe", robot,
                 "--out", tmp_path / "f.yaml")  # fmt: skip
    assert answer.exit_code == 0, answer.err
    file = yaml.safe_load((tmp_path / "f.yaml").read_text())
    assert file["gripper_mass"] == pytest.approx(1.0)
    assert file["gripper_com_pose"][2] == -0.02


def test_a_file_that_is_there_stays_unless_overwritten(tmp_path: Path, run: Run) -> None:
    out = tmp_path / "f.h"
    out.write_text("mine")
    source = write(tmp_path, cells())
    assert run("export", source, "--to", "c-header", "--out", out).exit_code == 2
    assert out.read_text() == "mine"
    assert run("export", source, "--to", "c-header", "--out", out, "--overwrite").exit_code == 0
    assert "footcal_cells" in out.read_text()
    assert json.loads(source.read_text())["robot"] == "rig"

"""``footcal kinematics`` against MuJoCo's own momentum of the biped, as the shell runs it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from footcal_cli.errors import lacks_memory, missing_library
from footcal_cli.recipe import read_recipe
from footcal_cli.records.files import read_record
from footcal_cli.records.results import RunRecord
from tests.conftest import Run

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")

from tests.core.urdf_robot import Truth, biped, joint_names, posture_at, urdf_of, write_urdf

RATE_HZ = 200.0
TIME_S = np.arange(0.0, 8.0, 1.0 / RATE_HZ)
NAMES = joint_names(biped())


def joint_log(time_s: np.ndarray = TIME_S, step_rad: float = 0.0) -> pd.DataFrame:
    """Joint positions of the motion, rounded to the steps of an encoder."""
    q = np.array([posture_at(t) for t in time_s])
    joints = np.round(q[:, 7:] / step_rad) * step_rad if step_rad else q[:, 7:]
    table = {"time_s": time_s, **{f"base_{a}_m": q[:, i] for i, a in enumerate("xyz")}}
    table |= {f"base_q{a}": q[:, 3 + i] for i, a in enumerate("wxyz")}
    table |= {f"{name}_rad": joints[:, i] for i, name in enumerate(NAMES)}
    return pd.DataFrame(table)


def write(folder: Path, table: pd.DataFrame, extra: str = "", mass_kg: float = 5.3) -> list[object]:
    """Log, recipe and URDF; the command's arguments."""
    table.to_parquet(folder / "joints.parquet")
    (folder / "r.toml").write_text(
        f'[robot]\nmass_kg = {mass_kg}\n[kinematics.feet]\nleft = "left_sole"\n'
        f'right = "right_sole"\n{extra}\n'
    )
    if not (folder / "robot.urdf").exists():
        write_urdf(folder)
    return [
        "kinematics", folder / "joints.parquet", "--recipe", folder / "r.toml",
        "--urdf", folder / "robot.urdf", "--out", folder / "out",
    ]  # fmt: skip


def columns(table: pd.DataFrame, pattern: str) -> np.ndarray:
    return table[[pattern.format(axis) for axis in "xyz"]].to_numpy()


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(values**2)))


def findings(folder: Path) -> set[str]:
    return {f.code for f in read_record(RunRecord, folder / "out" / "run.json").findings}


@pytest.mark.usefixtures("drawn")
def test_com_feet_and_momentum_are_those_of_the_physics_engine(run: Run, tmp_path: Path) -> None:
    answer = run(*write(tmp_path, joint_log()))
    assert answer.exit_code == 0, answer.err
    body = pd.read_parquet(tmp_path / "out" / "body.parquet")
    truth, inner = Truth(), slice(1, -1)
    com, soles = truth.com(TIME_S), truth.soles(TIME_S)
    assert np.abs(columns(body, "com_{}_m") - com).max() < 1e-4
    for i, foot in enumerate(("left", "right")):
        assert np.abs(columns(body, foot + "_foot_{}_m") - soles[:, i]).max() < 1e-4
    for pattern, wanted in (
        ("com_acc_{}_mps2", truth.com_acc(TIME_S)),
        ("angmom_rate_{}_nm", truth.angmom_rate(TIME_S)),
    ):
        found = columns(body, pattern)
        assert np.isnan(found[[0, -1]]).all()
        assert rms(found[inner] - wanted[inner]) < 0.01 * rms(wanted[inner])


@pytest.mark.parametrize("bits", [12, 14])
def test_the_noise_it_tells_is_the_error_it_makes(run: Run, tmp_path: Path, bits: int) -> None:
    answer = run(*write(tmp_path, joint_log(step_rad=2 * np.pi / 2**bits)))
    assert answer.exit_code == 0, answer.err
    rounded = pd.read_parquet(tmp_path / "out" / "body.parquet")
    exact_folder = tmp_path / "exact"
    exact_folder.mkdir()
    assert run(*write(exact_folder, joint_log())).exit_code == 0
    exact = pd.read_parquet(exact_folder / "out" / "body.parquet")
    inner = slice(40, -40)

    def error(pattern: str, axis: str) -> float:
        name = pattern.format(axis)
        return rms(rounded[name].to_numpy()[inner] - exact[name].to_numpy()[inner])

    noise = read_recipe(tmp_path / "out" / "noise.toml", {"online_replay"}).options[
        "online_replay"
    ]["noise"]
    mass = float(biped().body_mass.sum())
    arm = mass * float(exact["com_z_m"].median())
    force = mass * error("com_acc_{}_lowpass_mps2", "z")
    moment = max(
        np.hypot(arm * error("com_acc_{}_lowpass_mps2", a), error("angmom_rate_{}_lowpass_nm", b))
        for a, b in ("xy", "yx")
    )
    assert 0.7 < noise["force_n"] / force < 1.4
    assert 0.7 < noise["moment_nm"] / moment < 1.4


def test_degrees_other_names_and_angles_of_the_base_change_nothing(
    run: Run, tmp_path: Path
) -> None:
    table = joint_log(TIME_S[:200])
    assert run(*write(tmp_path, table)).exit_code == 0
    first = pd.read_parquet(tmp_path / "out" / "body.parquet")
    t = table["time_s"].to_numpy()
    rpy = [0.05 * np.sin(4 * t + 1), 0.06 * np.sin(7 * t), 0.2 * np.sin(1.5 * t)]
    other = table.drop(columns=[f"base_q{a}" for a in "wxyz"])
    for name, angle in zip(("roll", "pitch", "yaw"), rpy, strict=True):
        other[f"base_{name}_deg"] = np.rad2deg(angle)
    for name in NAMES:
        other[name] = np.rad2deg(other.pop(f"{name}_rad"))
    other["tilt"] = other.pop("base_pitch_deg")
    other["knee angle"] = np.deg2rad(other.pop("left_knee"))
    folder = tmp_path / "other"
    folder.mkdir()
    extra = (
        '[kinematics]\njoint_unit = "deg"\n'
        '[kinematics.joints]\nleft_knee = { column = "knee angle", unit = "rad" }\n'
        '[columns]\nbase_pitch_rad = { column = "tilt", unit = "deg" }'
    )
    arguments = write(folder, other)
    recipe = folder / "r.toml"
    recipe.write_text(extra + "\n" + recipe.read_text())
    assert run(*arguments).exit_code == 0
    second = pd.read_parquet(folder / "out" / "body.parquet")
    np.testing.assert_allclose(second, first, atol=1e-8)


def test_without_a_base_position_the_standing_foot_stays(run: Run, tmp_path: Path) -> None:
    """With one foot fixed the CoM seen from that foot must be the engine's."""
    table = joint_log(TIME_S[:200]).drop(columns=[f"base_{a}_m" for a in "xyz"])
    answer = run(*write(tmp_path, table), "--anchor", "left")
    assert answer.exit_code == 0, answer.err
    body = pd.read_parquet(tmp_path / "out" / "body.parquet")
    truth = Truth()
    com, soles = truth.com(TIME_S[:200]), truth.soles(TIME_S[:200])
    np.testing.assert_allclose(columns(body, "left_foot_{}_m"), 0.0, atol=1e-9)
    np.testing.assert_allclose(columns(body, "com_{}_m"), com - soles[:, 0], atol=1e-6)
    assert "base_position_inferred" in findings(tmp_path)


def test_a_model_of_another_weight_is_told(run: Run, tmp_path: Path) -> None:
    table = joint_log(TIME_S[:200])
    mass = float(biped().body_mass.sum())
    assert run(*write(tmp_path, table, mass_kg=mass)).exit_code == 0
    assert "model_mass_differs" not in findings(tmp_path)
    table["left_fz_n"] = table["right_fz_n"] = 0.5 * 1.2 * mass * 9.80665
    assert run(*write(tmp_path, table, mass_kg=1.1 * mass), "--overwrite").exit_code == 0
    assert {"model_mass_differs", "model_mass_not_carried"} <= findings(tmp_path)


def test_joints_that_are_missing_or_unknown_are_named(run: Run, tmp_path: Path) -> None:
    table = joint_log(TIME_S[:50]).drop(columns=["left_knee_rad"])
    answer = run(*write(tmp_path, table))
    assert answer.exit_code == 2
    assert "left_knee" in answer.err
    assert "[kinematics.fixed]" in answer.err
    assert run(*write(tmp_path, table, "[kinematics.fixed]\nleft_knee = 0.1")).exit_code == 0
    answer = run(*write(tmp_path, table, "[kinematics.fixed]\nleft_kne = 0.1"), "--overwrite")
    assert answer.exit_code == 2
    assert "did you mean 'left_knee'" in answer.err
    answer = run(*write(tmp_path, table, '[kinematics.joints]\nleft_knee = "k"'), "--overwrite")
    assert answer.exit_code == 3
    assert "missing column 'k'" in answer.err


def test_a_log_without_a_whole_row_is_refused(run: Run, tmp_path: Path) -> None:
    """Nothing may follow from rows in which a joint or the base is unknown."""
    log = joint_log(TIME_S[:400])
    empty = log.assign(**{f"{NAMES[2]}_rad": np.nan})
    answer = run(*write(tmp_path, empty))
    assert answer.exit_code == 3
    assert NAMES[2] in answer.err
    assert not (tmp_path / "out").exists()
    rows = np.arange(len(log)) % 2 == 0  # a joint known in these rows, the base in the others
    never = log.assign(
        **{
            f"{NAMES[2]}_rad": log[f"{NAMES[2]}_rad"].where(rows),
            "base_qw": log["base_qw"].mask(rows),
        }
    )
    answer = run(*write(tmp_path, never))
    assert answer.exit_code == 3
    assert "no row" in answer.err
    assert "reading" not in answer.err
    one_lost = log.assign(
        **{f"{NAMES[2]}_rad": log[f"{NAMES[2]}_rad"].mask(~rows & (log.index < 9))}
    )
    assert run(*write(tmp_path, one_lost)).exit_code == 0


def test_joints_that_follow_slide_or_turn_on(run: Run, tmp_path: Path) -> None:
    """A mass of 1 kg on each of a continuous, a following and a sliding joint: CoM by hand."""
    mass = '<inertial><origin xyz="{}"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
    mass += 'ixz="0" iyz="0"/></inertial>'
    joint = '<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_l"/>{2}</joint>'
    limit = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
    text = "".join(
        [
            '<robot name="r"><link name="base">', mass.format("0 0 0"), "</link>",
            *(f'<link name="{n}_l">{mass.format(p)}</link>'
              for n, p in (("turn", "1 0 0"), ("follow", "1 0 0"), ("slide", "0 0 0"))),
            joint.format("turn", "continuous", '<axis xyz="0 0 1"/>'),
            joint.format("follow", "revolute", f'<axis xyz="0 0 1"/>{limit}'
                         '<mimic joint="turn" multiplier="-0.5" offset="0.2"/>'),
            joint.format("slide", "prismatic", f'<axis xyz="0 0 1"/>{limit}'),
            "</robot>",
        ]
    )  # fmt: skip
    write_urdf(tmp_path, text)
    t = TIME_S[:100]
    turn, slide = 7.0 + 2.0 * t, 100.0 * np.sin(t)
    table = pd.DataFrame({"time_s": t, "turn": turn, "slide_mm": slide, "base_qw": 1.0})
    for axis in "xyz":
        table[f"base_q{axis}"] = 0.0
        table[f"base_{axis}_m"] = 0.0
    arguments = write(tmp_path, table)
    (tmp_path / "r.toml").write_text('[kinematics.feet]\nonly = "base"\n')
    answer = run(*arguments)
    assert answer.exit_code == 0, answer.err
    body = pd.read_parquet(tmp_path / "out" / "body.parquet")
    follow = -0.5 * turn + 0.2
    expected = np.column_stack(
        [np.cos(turn) + np.cos(follow), np.sin(turn) + np.sin(follow), slide / 1e3]
    )
    np.testing.assert_allclose(columns(body, "com_{}_m"), expected / 4, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot", "not a URDF"),
        ('<robot name="r"><link name="base"/></robot>', "no link has a mass"),
        (
            urdf_of(biped()).replace('"left_knee" type="revolute"', '"left_knee" type="planar"'),
            "joint 'left_knee' is planar",
        ),
    ],
)
def test_a_model_that_cannot_be_used_is_refused(
    run: Run, tmp_path: Path, text: str, words: str
) -> None:
    write_urdf(tmp_path, text)
    answer = run(*write(tmp_path, joint_log(TIME_S[:20])))
    assert answer.exit_code == 3
    assert words in answer.err
    assert answer.err.count("\n") == 1


def test_a_library_without_memory_to_load_it_is_not_called_missing() -> None:
    words = "libpinocchio.so: failed to map segment from shared object"
    there = missing_library("json", ImportError(words), "needs json", "install it")
    absent = missing_library("no_such_package", ImportError(words), "needs it", "install it")
    assert (there.exit_code, absent.exit_code) == (74, 2)
    assert words.rpartition(": ")[2] in there.line()
    assert lacks_memory(ImportError(words))
    assert not lacks_memory(ImportError("undefined symbol"))


def test_without_pinocchio_it_says_how_to_install_it(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = write(tmp_path, joint_log(TIME_S[:20]))
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    answer = run(*arguments)
    assert answer.exit_code == 2
    assert "pip install 'pin>=3.1'" in answer.err

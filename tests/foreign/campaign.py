"""Every calibrating command on robots of this world: errors in units of the sd it states.

A task is one seed and one command, run as its user runs it; its answer is a small JSON file, so
that a campaign that was stopped goes on where it was.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.foreign.ankles import AXES, ankle_offsets
from tests.foreign.bench import weights
from tests.foreign.biped import FEET, GRAVITY_MPS2, draw_biped
from tests.foreign.drawn import anew, as_sold, sold_walk, stand_on_ankles, walk_on_ankles
from tests.foreign.files import Recorded, write
from tests.foreign.kinds import DRAW, kind_of
from tests.foreign.legs import draw_hexapod, hang, poses
from tests.foreign.noise import Array
from tests.foreign.owners import OWNERS, filled, logged
from tests.foreign.points import LEGS, points, quadruped_truth
from tests.foreign.streams import stand, walk
from tests.foreign.wrist import TOOL, wrist

Ratios = dict[str, list[list[float]]]
"""Quantity -> pairs of error and stated sd."""


@dataclass(frozen=True)
class Task:
    """One command in one kind of recording.

    Parameters
    ----------
    command : of footcal
    record : the recording of a seed
    after : the task whose parameters it starts from
    judge : answer, seed and truth to errors
    """

    command: str
    record: Callable[[int], Recorded]
    after: str | None
    judge: Callable[[Mapping[str, Any], int, Mapping[str, Any]], Ratios]


def cell_errors(found: Mapping[str, Any], seed: int, truth: Mapping[str, Any]) -> Ratios:
    """Relative errors of scales, and errors of the force without load, N."""
    robot, ratios = draw_biped(seed), Ratios(scale=[], zero=[])
    scales = robot.scale * np.asarray(truth.get("gain", 1.0))
    for i, channel in enumerate(robot.channels):
        if _extended(found, channel):
            continue
        names = (f"{channel}.scale", f"{channel}.bias")
        values, covariance = _known(found, names)
        scale = np.array([1.0 / scales[i], 0.0])
        zero = np.array([robot.zero[i], 1.0])
        moved = float(truth["drift_n"][i])
        error = values - [scales[i], -scales[i] * robot.zero[i]]
        for kind, row in (("scale", scale), ("zero", zero)):
            off = float(row @ error) + (moved if kind == "zero" else 0.0)
            ratios[kind].append([off, float(np.sqrt(row @ covariance @ row))])
    return ratios


def ankle_errors(found: Mapping[str, Any], seed: int, truth: Mapping[str, Any]) -> Ratios:
    """Offsets of both ankle transducers, forces and torques, and what hangs below them."""
    robot, ratios = draw_biped(seed), Ratios()
    gains = np.asarray(truth.get("gains", np.zeros((len(FEET), len(AXES)))))
    for foot, offsets, gain in zip(FEET, ankle_offsets(robot), gains, strict=True):
        for axis, true in zip(AXES, offsets, strict=True):
            kind = "force offset" if axis[0] == "f" else "torque offset"
            _add(ratios, kind, found, f"{foot}.offset_{axis}", float(true))
        stated = robot.recipe()["feet"][foot]
        for axis, true, told in zip("xyz", robot.com_below_m, stated["com_below_m"], strict=True):
            name = f"{foot}.com_below_{axis}"
            if name in found["parameters"]:
                _add(ratios, "leg CoM", found, name, true - told)
        true = robot.below_kg * GRAVITY_MPS2 - stated["weight_below_n"]
        _add(ratios, "weight", found, f"{foot}.weight", true)
        for axis, own in zip(AXES, gain, strict=True):
            if (name := f"{foot}.scale_{axis}") in found["parameters"]:
                _add(ratios, "scale", found, name, float(own))
    return ratios


def _extended(found: Mapping[str, Any], channel: str) -> bool:
    """Whether a cell has more than a scale and a bias."""
    own = {n for n in found["parameters"] if n.startswith(f"{channel}.")}
    return bool(own - {f"{channel}.scale", f"{channel}.bias"})


def tool_errors(found: Mapping[str, Any], seed: int, truth: Mapping[str, Any]) -> Ratios:
    """Offsets of a wrist's transducer, and weight and CoM of the tool, whatever they are called."""
    (name,) = {n.split(".")[0] for n in found["parameters"] if n.endswith(".offset_fx")}
    own = {n.replace(TOOL, name): v for n, v in truth["parameters"].items()}
    ratios = _against(found, own, "robot.")
    for axis, true in zip("xyz", truth["com_m"], strict=True):
        _add(ratios, "leg CoM", found, f"{name}.com_{axis}_mean", float(true))
    return ratios


def point_errors(found: Mapping[str, Any], seed: int, _: object) -> Ratios:
    """Scales (relative) and zeros of the four cells of a quadruped."""
    robot, ratios = quadruped_truth(seed), Ratios(scale=[], zero=[])
    for leg, scale, zero in zip(LEGS, robot["scale"], robot["zero"], strict=True):
        values, covariance = _known(found, (f"{leg}_foot.scale", f"{leg}_foot.bias"))
        error = values - [scale, -scale * zero]
        for kind, row in (("scale", [1.0 / scale, 0.0]), ("zero", [zero, 1.0])):
            at = np.array(row)
            ratios[kind].append([float(at @ error), float(np.sqrt(at @ covariance @ at))])
    return ratios


def _poised(seed: int) -> Recorded:
    return points(seed, walking=False)


def _crawling(seed: int) -> Recorded:
    return points(seed, walking=True)


def hanging_errors(found: Mapping[str, Any], seed: int, _: object) -> Ratios:
    """Weight, offsets of forces and torques, and CoM of all legs."""
    robot, true = draw_hexapod(seed), draw_hexapod(seed).truth()
    hand = np.ones(3)
    if robot.kind.name == "left-handed transducers":  # in the axes that its readings have
        hand = np.array([1.0, -1.0, 1.0])
        other = (".offset_fy", ".offset_tx", ".offset_tz")
        true = {n: -v if n.endswith(other) else v for n, v in true.items()}
    ratios = _against(found, true, "robot.")
    for k, leg in enumerate(robot.legs):
        for axis, row in zip("xyz", hand[:, None] * robot.arm_m[k], strict=True):
            for what, true in zip(("mean", "sin", "cos", "sin2"), row, strict=True):
                name = f"{leg}.com_{axis}_{what}"
                if name in found["parameters"]:
                    _add(ratios, "leg CoM", found, name, float(true))
    return ratios


def standing_errors(found: Mapping[str, Any], seed: int, _: object) -> Ratios:
    """Mounting of all transducers, and the robot's weight."""
    robot = draw_hexapod(seed)
    ratios = _against(found, {"robot.weight": robot.truth()["robot.weight"]}, "")
    for k, leg in enumerate(robot.legs):
        nominal = robot.nominal_rot_bt[k]
        turn = Rotation.from_matrix(nominal.T @ robot.rot_bt[k]).as_rotvec()
        shift = nominal.T @ (robot.hip_m[k] - robot.chassis_com_m - robot.nominal_hip_m[k])
        for kind, label, true in (("rot", "turn", turn), ("pos", "shift", shift)):
            for axis, value in zip("xyz", true, strict=True):
                _add(ratios, label, found, f"{leg}.mount_{kind}_{axis}", float(value))
    return ratios


def _against(found: Mapping[str, Any], truth: Mapping[str, float], skip: str) -> Ratios:
    kinds = {"weight": "weight", "f": "force offset", "t": "torque offset"}
    ratios: Ratios = {}
    for name, true in truth.items():
        if skip and name.startswith(skip):
            continue
        last = name.split(".")[1].removeprefix("offset_")
        _add(ratios, kinds[last if last == "weight" else last[0]], found, name, true)
    return ratios


def _add(ratios: Ratios, kind: str, found: Mapping[str, Any], name: str, true: float) -> None:
    one = found["parameters"][name]
    ratios.setdefault(kind, []).append([one["value"] - true, one["sd"]])


def _known(found: Mapping[str, Any], names: tuple[str, ...]) -> tuple[Array, Array]:
    """Values and joint covariance of some parameters."""
    values = np.array([found["parameters"][name]["value"] for name in names])
    for block in found["covariance"]:
        if set(names) <= set(block["names"]):
            at = [block["names"].index(name) for name in names]
            return values, np.array(block["matrix"])[np.ix_(at, at)]
    raise KeyError(names)


TASKS = {
    "offline-fit": Task("offline-fit", weights, None, cell_errors),
    "static-init": Task("static-init", stand, "offline-fit", cell_errors),
    "online-replay": Task("online-replay", walk, "offline-fit", cell_errors),
    "static-init, nameplate": Task("static-init", stand, None, cell_errors),
    "online-replay, nameplate": Task("online-replay", walk, None, cell_errors),
    "static-init, ankles": Task("static-init", stand, None, ankle_errors),
    "online-replay, ankles": Task("online-replay", walk, None, ankle_errors),
    "static-init, true nameplate": Task("static-init", as_sold, None, cell_errors),
    "online-replay, true nameplate": Task("online-replay", sold_walk, None, cell_errors),
    "static-init, mounted anew": Task("static-init", anew(stand), "offline-fit", cell_errors),
    "online-replay, mounted anew": Task("online-replay", anew(walk), "offline-fit", cell_errors),
    "online-replay, ankles off": Task("online-replay", walk_on_ankles, None, ankle_errors),
    "static-init, ankles off": Task("static-init", stand_on_ankles, None, ankle_errors),
    "hang-calib": Task("hang-calib", hang, None, hanging_errors),
    "pose-calib": Task("pose-calib", poses, "hang-calib", standing_errors),
    "hang-calib, wrist": Task("hang-calib", wrist, None, tool_errors),
    "static-init, points": Task("static-init", _poised, None, point_errors),
    "online-replay, points": Task("online-replay", _crawling, None, point_errors),
}


_AS_STATED = ("true nameplate", "mounted anew")


def tasks_of(seed: int) -> tuple[str, ...]:
    """The commands that a robot of the fleet can be given."""
    kind, name = kind_of(seed), kind_of(seed).name
    if name == "wrist sensor with a tool":
        return ("hang-calib, wrist",)
    if name == "quadruped on points":
        return "static-init, points", "online-replay, points"
    if kind.legs:
        return "hang-calib", "pose-calib"
    if kind.cells == 0:
        return tuple(name for name in TASKS if "ankles" in name)
    return (*tuple(TASKS)[:5], *(name for name in TASKS if name.endswith(_AS_STATED)))


def _by_init(recorded: Recorded, folder: Path) -> Path:
    """Logs as their owner writes them, and the recipe of ``footcal init``, filled in."""
    folder.mkdir(parents=True, exist_ok=True)
    made, recipe = logged(recorded), folder / "recipe.toml"
    for name, frame in made.files.items():
        frame.to_csv(folder / name, index=False)
    paths = [str(folder / name) for name in made.files]
    subprocess.run(
        [sys.executable, "-m", "footcal_cli", "init", *paths, "-o", str(recipe), "--overwrite"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    recipe.write_text(filled(recipe.read_text(encoding="utf-8"), made.fill), encoding="utf-8")
    return recipe


def run(name: str, seed: int, folder: Path) -> dict[str, Any]:
    """The answer of one task: exit code, verdict, findings and errors; kept in `folder`."""
    task, own = TASKS[name], folder / f"{seed}" / name.replace(", ", "-").replace(" ", "-")
    answer = own / "answer.json"
    if answer.exists():
        return dict(json.loads(answer.read_text(encoding="utf-8")))
    recorded = task.record(seed)
    habit = OWNERS.get(seed % DRAW)
    recipe = write(recorded, own) if habit is None else _by_init(habit(recorded), own)
    arguments = [task.command, "--recipe", recipe, "--no-pictures",
                 "--quiet", "--overwrite", "--out", own / "out"]  # fmt: skip
    if task.after is not None:
        run(task.after, seed, folder)
        before = folder / f"{seed}" / task.after / "parameters.json"
        arguments += ["--parameters", before] if before.exists() else []
    done = subprocess.run(
        [sys.executable, "-m", "footcal_cli", *map(str, arguments)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    said: dict[str, Any] = {"code": done.returncode, "error": done.stderr[-500:], "ratios": {}}
    written = own / "out" / "run.json"
    if written.exists():
        record = json.loads(written.read_text(encoding="utf-8"))
        said["level"] = record["verdict"]["level"]
        said["sentence"] = record["verdict"]["sentence"]
        said["findings"] = [[f["severity"], f["code"], f["where"]] for f in record["findings"]]
    made = own / "out" / "parameters.json"
    if made.exists():
        found = json.loads(made.read_text(encoding="utf-8"))
        said["ratios"] = task.judge(found, seed, recorded.truth)
        shutil.copy(made, own / "parameters.json")
    for log in [*own.glob("*.parquet"), *own.glob("*.csv")]:
        log.unlink()
    shutil.rmtree(own / "out", ignore_errors=True)
    answer.write_text(json.dumps(said, indent=1), encoding="utf-8")
    return said

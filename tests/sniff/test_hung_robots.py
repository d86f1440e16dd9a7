"""Robots that hang and stand, as laboratories write them: what init makes of their logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.drawn_turns import nominal
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.recipe_text import recipe_text
from footcal_cli.sniff.several import parts_of
from footcal_cli.sniff.sides import side_in, sides_in
from tests.conftest import Run
from tests.sniff.hung_robots import (
    AXES,
    DOWN,
    ROWS,
    WEIGHT_N,
    legs_in_files,
    legs_in_one_file,
    stood,
    swing,
    wrench_of,
    yawed,
)

HEXAPOD = {leg: yawed(a) for leg, a in
           {"L1": 50, "L2": 90, "L3": 130, "R1": -50, "R2": -90, "R3": -130}.items()}  # fmt: skip
QUADRUPED = {leg: yawed(a) for leg, a in {"LF": 0, "RF": 0, "LH": 0, "RH": 0}.items()}
GERMAN = {leg: Rotation.from_euler("x", a, degrees=True)
          for leg, a in {"VL": -90, "HL": -90, "VR": 90, "HR": 90}.items()}  # fmt: skip
ALONG = {"xu": "-x", "xd": "+x", "zu": "-z", "zd": "+z"}


def _part(paths: list[Path]) -> Part:
    (part,), others = parts_of([guess_file(path) for path in paths])
    assert not others
    return part


def _rpy(part: Part, leg: str) -> list[float]:
    """Angles that init offers for a leg."""
    table = next(t for t in part.plan.robot if t.startswith(f"[robot.legs.{leg}]"))
    line = next(x for x in table.splitlines() if x.startswith("rotation_rpy_rad"))
    return [float(v) for v in line.partition("[")[2].partition("]")[0].split(",")]


@pytest.mark.parametrize(
    ("names", "legs", "phase"),
    [
        ({k: f"hang_{k[0].upper()}{'up' if k[1] == 'u' else 'down'}.csv" for k in DOWN}, QUADRUPED,
         "{leg}_q2"),
        ({k: f"haengen_{k[0]}{'auf' if k[1] == 'u' else 'ab'}.csv" for k in DOWN}, GERMAN,
         "Phi_{leg} [°]"),
        ({k: f"tsuri_{k}.csv" for k in DOWN}, HEXAPOD, "{leg}_pitch"),
        ({"xu": "hang_minus_x.csv", "xd": "hang_x.csv", "zu": "hang_minus_z.csv",
          "zd": "hang_z.csv"}, GERMAN, "theta_{leg}_deg"),
    ],
)  # fmt: skip
def test_orientations_in_names_of_files_of_whole_robots(
    tmp_path: Path, names: dict[str, str], legs: dict[str, Rotation], phase: str
) -> None:
    part = _part(legs_in_one_file(tmp_path, names, legs, phase))
    assert part.plan.command == "hang-calib"
    assert part.plan.ready
    said = part.plan.entries["orientation"].names
    assert said == {name: ALONG[key] for key, name in names.items()}
    for own in part.plan.wide.values():
        assert own["phase_rad"].unit == "deg"
    for leg, turn in legs.items():
        name = next(n for n in part.plan.wide if part.plan.wide[n]["fx_n"].column.column[:2] == leg)  # type: ignore[union-attr]
        drawn = Rotation.from_euler("xyz", _rpy(part, name))
        assert (drawn.inv() * turn).magnitude() < 1e-3


def test_names_of_files_that_say_no_axis_are_asked_for(tmp_path: Path) -> None:
    names = {key: f"A{i}.csv" for i, key in enumerate(DOWN)}
    part = _part(legs_in_one_file(tmp_path, names, GERMAN, "Phi_{leg}"))
    asked = "\n".join(line for blank in part.plan.blanks for line in blank.lines)
    assert '"A0.csv" = ""' in asked
    assert any("A0.csv" in blank.why for blank in part.plan.blanks)
    assert all(any(t.startswith(f"[robot.legs.{n}]") for t in part.plan.robot)
               for n in part.plan.wide)  # fmt: skip


@pytest.mark.parametrize("joints", [True, False])
def test_a_file_for_each_leg_and_orientation(tmp_path: Path, run: Run, joints: bool) -> None:
    paths = legs_in_files(tmp_path, HEXAPOD, joints=joints)
    recipe = tmp_path / "r.toml"
    answer = run("init", *paths, "--out", recipe)
    assert answer.exit_code == 0, answer.err
    assert f"next: footcal hang-calib --recipe {recipe}" in answer.out
    done = run("hang-calib", "--recipe", recipe, "--out", tmp_path / "out", "--no-pictures")
    assert done.exit_code == 0, done.err
    found = pd.read_json(tmp_path / "out" / "parameters.json", typ="series")["parameters"]
    for leg in HEXAPOD:
        assert found[f"{leg}.weight"]["value"] == pytest.approx(WEIGHT_N, abs=0.1)
    if joints:
        text = recipe.read_text()
        assert 'phase_rad = { column = "run_xd.column_3", unit = "rad" }' in text
        assert text.count("Check: the joints that move") == 1


def test_what_init_leaves_as_a_comment_may_be_filled_in(tmp_path: Path, run: Run) -> None:
    names = {k: f"hang_{k}.csv" for k in DOWN}
    paths = legs_in_one_file(tmp_path, names, GERMAN, "Phi_{leg}_deg")
    part = _part(paths)
    text = recipe_text([part], tmp_path / "r.toml", "--recipe r.toml")
    filled = text.replace("# leg_weight_n =    ", "leg_weight_n = 8.5    ")
    assert filled != text
    (tmp_path / "r.toml").write_text(filled)
    done = run("hang-calib", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "o",
               "--no-pictures")  # fmt: skip
    assert done.exit_code == 0, done.err


@pytest.mark.parametrize(
    ("turn", "drawn"),
    [
        (("zyx", (31.0, 1.2, 0.4)), ("z", 30.0)), (("zyx", (-47.5, 0.5, 1.0)), ("z", -45.0)),
        (("zyx", (50.2, 0.3, -0.5)), ("z", 50.0)), (("xyz", (-86.0, 2.0, 3.0)), ("x", -90.0)),
        (("zyx", (137.0, 0.0, 1.0)), ("z", 135.0)), (("zyx", (12.0, 0.2, 0.1)), ("z", 12.0)),
    ],
)  # fmt: skip
def test_a_turn_is_what_a_drawing_has(
    turn: tuple[str, tuple[float, ...]], drawn: tuple[str, float]
) -> None:
    found = nominal(Rotation.from_euler(*turn, degrees=True).as_matrix())
    assert np.allclose(found, Rotation.from_euler(*drawn, degrees=True).as_matrix(), atol=1e-9)


@pytest.mark.parametrize(
    ("word", "axis"),
    [
        ("haengen_xauf.asc", "-x"), ("prov_z_upp.csv", "-z"), ("wisi_y_dół", "+y"),
        ("hangXup", "-x"), ("tsuri_zd", "+z"), ("yukarı_x", "-x"),
    ],
)  # fmt: skip
def test_ways_up_in_more_languages(word: str, axis: str) -> None:
    assert side_in(word) == (axis, True)


def test_a_bare_axis_is_positive_next_to_a_negative_one() -> None:
    assert [axis for axis, _ in sides_in(["x", "-x", "z", "-z"]).values()] == ["+x", "-x", "+z",
                                                                             "-z"]  # fmt: skip
    assert [axis for axis, _ in sides_in(["x", "y", "z"]).values()] == [None] * 3


@pytest.mark.parametrize("form", ["{} {} [{}]", "{}_{}_{}"])
@pytest.mark.parametrize(("mean", "scatter"), [("ORT", "SS"), ("moy", "ét"), ("平均", "偏差")])
def test_means_and_their_scatter_in_any_language(
    tmp_path: Path, mean: str, scatter: str, form: str
) -> None:
    rng = np.random.default_rng(3)
    turns = Rotation.random(24, random_state=2)
    down = turns.inv().apply([0.0, 0.0, -1.0])
    force = WEIGHT_N * down
    read = np.hstack([force, np.cross(COM, force)]) + 0.3
    table: dict[str, np.ndarray] = {}
    for name, angle in zip("ABC", turns.as_euler("ZYX", degrees=True).T, strict=True):
        table[f"{name} [°]"] = angle.round(2)
    for i, axis in enumerate(AXES):
        unit = "N" if i < 3 else "Nm"
        table[form.format(axis, mean, unit)] = read[:, i].round(3)
        table[form.format(axis, scatter, unit)] = rng.uniform(0.01, 0.02, 24).round(3)
    log = tmp_path / "form.csv"
    pd.DataFrame(table).to_csv(log, sep=";", decimal=",", index=False)
    part = _part([log])
    assert part.plan.command == "hang-calib"
    assert part.plan.ready
    column = part.plan.entries["tz_nm"].column
    assert column is not None
    assert column.column == form.format("Mz", mean, "Nm")


def test_words_behind_axes_may_be_legs(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    parts = []
    for down in DOWN.values():
        columns = {
            f"{axis} {leg}": wrench_of(turn, down, swing(), rng)[:, i]
            for leg, turn in GERMAN.items() for i, axis in enumerate(AXES)
        }  # fmt: skip
        down_as = {f"g{a}": np.full(ROWS, v) for a, v in zip("xyz", down, strict=True)}
        parts.append(pd.DataFrame({**columns, **down_as}))
    log = tmp_path / "hung.csv"
    pd.concat(parts).round(4).to_csv(log, index=False)
    assert {*_part([log]).plan.wide} >= {"vl", "hl", "vr", "hr"}


def test_numbered_stretches_of_rest_are_poses(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    body, legs = stood(QUADRUPED, 14, rng)
    roll, pitch, yaw = (np.repeat(a, 40) for a in body.as_euler("ZYX", degrees=True).T[::-1])
    table = {"t": 0.05 * np.arange(14 * 40), "Pose": np.repeat(np.arange(1, 15), 40),
             "Roll": roll, "Pitch": pitch, "Yaw": yaw}  # fmt: skip
    for leg, read in legs.items():
        for axis, values in zip(AXES, read.T, strict=True):
            table[f"{leg}_{axis}"] = np.repeat(values, 40) + rng.normal(0.0, 0.05, 14 * 40)
    log = tmp_path / "stand.csv"
    pd.DataFrame(table).round(4).to_csv(log, index=False)
    plan = _part([log]).plan
    assert (plan.role, plan.entries["pose"].column.column) == ("poses", "Pose")  # type: ignore[union-attr]
    assert any(line.startswith("# chassis_com_m") for line in plan.options)


def test_lists_of_a_floating_base_and_of_wrenches(tmp_path: Path) -> None:
    rng = np.random.default_rng(9)
    body, legs = stood(QUADRUPED, 30, rng)
    q = np.hstack([rng.normal(0, 0.01, (30, 3)), body.as_quat(), rng.normal(0, 0.3, (30, 12))])
    log = tmp_path / "poses.parquet"
    pd.DataFrame(
        {"pose": np.arange(30), "q": list(q)} | {f"phi_{leg}": list(w) for leg, w in legs.items()}
    ).to_parquet(log)
    plan = _part([log]).plan
    assert plan.role == "poses"
    assert {*plan.wide} == {"fl", "fr", "hl", "hr"}
    columns = {n: e.column.column for n, e in plan.entries.items() if e.column is not None}
    assert [columns[f"body_q{a}"] for a in "xyzw"] == ["q_3", "q_4", "q_5", "q_6"]
    assert plan.wide["hr"]["tz_nm"].column.column == "phi_RH_5"  # type: ignore[union-attr]


COM = np.array([0.01, -0.02, 0.09])

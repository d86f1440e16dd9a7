"""Walks and hung legs as labs keep them: names in their own words, zeros and sheets beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from footcal_cli.sniff.bodies import body_of
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.motion import body_entries
from footcal_cli.sniff.names import NameGuess
from footcal_cli.sniff.one_sign import under_hung_names
from footcal_cli.sniff.plan import LogPlan, of
from footcal_cli.sniff.several import parts_of
from footcal_cli.sniff.text import TextGuess
from footcal_cli.tables.reading import Layout
from tests.conftest import Run
from tests.sniff.hung_robots import AXES, COM_M, OFFSET, WEIGHT_N
from tests.sniff.test_bodies_in_files import _topic
from tests.sniff.test_walks import Walk, _bench, _columns, _parts, _written, _xyz

CELLS = {"AVA": (0, 0), "AVI": (0, 1), "AHA": (0, 2), "CVA": (1, 0), "CVI": (1, 1), "CHA": (1, 2)}
"""Cells under the left and the right foot by names that say no side."""


def _cells(
    walk: Walk, names: Mapping[str, tuple[int, int]], end: str = ""
) -> dict[str, FloatArray]:
    return {f"{name}{end}": walk.counts(foot, cell) for name, (foot, cell) in names.items()}


def _body(walk: Walk, feet: tuple[str, str] = ("SohleLi_", "SohleRe_")) -> dict[str, FloatArray]:
    made = {"Zeit [s]": walk.t, **_xyz("KSP_", walk.com), **_xyz("KSP_a", walk.acc)}
    for i, foot in enumerate(feet):
        made |= _xyz(foot, walk.feet[:, i])
    return made


def _zeros(path: Path, values: Mapping[str, float], said: str = "wert") -> Path:
    pd.DataFrame({"zelle": [*values], said: [*values.values()]}).to_csv(path, index=False)
    return path


def test_cells_rest_in_the_swings_of_their_foot_and_moments_are_no_cells(tmp_path: Path) -> None:
    walk = Walk()
    body = _body(walk)
    rng = np.random.default_rng(7)
    in_the_air = walk.air.sum(axis=1) * np.sin(40 * walk.t)
    body |= {f"dL_{a} [Nm]": 3 * in_the_air + rng.normal(0, 0.1, walk.t.size) for a in "xy"}
    found = _parts([
        _written(tmp_path / "koerper.csv", body),
        _written(tmp_path / "sohlen.csv", {"Zeit [s]": walk.t, **_cells(walk, CELLS, " [Digit]")}),
        _bench(tmp_path / "bank.csv", dict.fromkeys(CELLS, "Anzeige")),
    ])  # fmt: skip
    columns = _columns(found["cells"].plan)
    assert {n: c for n, c in columns.items() if n.startswith("left")} == {
        f"left_{place}_counts": f"A{place.upper()} [Digit]" for place in ("va", "vi", "ha")
    }  # fmt: skip
    assert set(found["weights"].plan.channels) == set(found["cells"].plan.channels)
    assert _columns(found["body"].plan)["angmom_rate_y_nm"] == "dL_y [Nm]"


@pytest.mark.parametrize("off", [0.0, 40.0])
def test_a_row_for_each_cell_is_its_zero_where_its_own_readings_end(
    tmp_path: Path, off: float
) -> None:
    walk = Walk()
    logs = [
        _written(tmp_path / "body.csv", _body(walk)),
        _written(tmp_path / "cells.csv", {"Zeit [s]": walk.t, **_cells(walk, CELLS)}),
        _bench(tmp_path / "bank.csv", dict.fromkeys(CELLS, "wert")),
    ]  # fmt: skip
    zeros = {name: 500.0 + 40 * cell + 3 for name, (_, cell) in CELLS.items()}
    sheet = _zeros(tmp_path / "abc.csv", {n: v + off * v for n, v in zeros.items()})
    parts, _ = parts_of([guess_file(path) for path in (*logs, sheet)])
    roles = {part.plan.role: part.plan for part in parts}
    assert ("zeros" in roles) == (off == 0.0), "other numbers are no zeros"
    if off == 0.0:
        assert _columns(roles["zeros"])["right_vi_counts"] == "CVI.wert"


def test_numbered_cells_have_their_zeros_by_number(tmp_path: Path) -> None:
    walk = Walk()
    numbers = {str(3 * foot + cell + 1): (foot, cell) for foot in (0, 1) for cell in range(3)}
    found = _parts([
        _written(tmp_path / "body.csv", _body(walk)),
        _written(tmp_path / "cells.csv", {
            "Zeit [s]": walk.t,
            **{f"Stik{n}_mVV": walk.counts(*at) / 7000 for n, at in numbers.items()},
        }),
        _zeros(tmp_path / "nulpunkt.csv", {n: 0.0714 + 0.006 * c for n, (_, c) in numbers.items()}),
    ])  # fmt: skip
    assert _columns(found["zeros"].plan)["right_stik4_counts"] == "4.wert"


def test_an_angular_momentum_is_neither_a_foot_nor_a_rate(tmp_path: Path) -> None:
    walk = Walk()
    body = _body(walk, ("migi_ashi_", "hidari_ashi_"))
    body |= {"L_x": walk.rate[:, 0], "L_y": walk.rate[:, 1]} | _xyz("kaku_", walk.rate)
    file = guess_file(_written(tmp_path / "jotai.csv", body))
    said = replace(file.text, above=("`kaku_x/y/z` angular momentum about the CoM [Nms] (model)",))
    entries = _entries(replace(file, text=said))
    assert entries["left_foot_x_m"] in ("migi_ashi_x", "hidari_ashi_x")
    assert not any(name.startswith("angmom_rate") for name in entries)
    assert entries["angmom_x_nms"] == "kaku_x", "its rate is taken"
    assert _entries(file)["angmom_rate_x_nm"] == "kaku_x", "of itself it may be the rate"


def _entries(file: FileGuess) -> dict[str, str]:
    body = body_of(file)
    assert body is not None
    found = body_entries(body.file).items()
    return {name: e.column.column for name, e in found if e.column is not None}


def test_three_columns_beside_a_foots_place_are_its_angles(tmp_path: Path) -> None:
    walk = Walk()
    body = _body(walk, ("VF_", "HF_"))
    for i, foot in enumerate(("VF_", "HF_")):
        angles = np.degrees(walk.rpy[:, i]).T
        body |= {f"{foot}{n}": v for n, v in zip(("qua", "stamp", "gir"), angles, strict=True)}
    body |= {f"{foot}{n}": walk.counts(i, k) for i, foot in enumerate(("V", "H"))
             for k, n in enumerate(("c1", "c2", "c3"))}  # fmt: skip
    entries = _entries(guess_file(_written(tmp_path / "gang.csv", body)))
    assert entries["right_foot_pitch_rad"] == "HF_stamp"
    assert entries["left_foot_yaw_rad"] == "VF_gir"


@pytest.mark.parametrize(
    ("words", "end", "line", "whys"),
    [
        (("gier", "stamp", "rol"), "_rad", "R = Rz(gier) Ry(stamp) Rx(rol), voet naar wereld", ""),
        (("psi", "theta", "phi"), "", "orientation: rot_z(psi) * rot_y(theta) * rot_x(phi)", ""),
        (("gier", "stamp", "rol"), "_rad", "", "roll and pitch by what stands next to it"),
        (("rolido", "cabeceo", "guinada"), "_rad", "", "roll by what stands next to it"),
        (("skew", "vinkling", "yaw"), "_rad", "", "roll and pitch by what stands next to it"),
    ],
)  # fmt: skip
def test_angles_by_a_formula_or_beside_one_that_is_known(
    tmp_path: Path, words: tuple[str, ...], end: str, line: str, whys: str
) -> None:
    walk, feet = Walk(), ("pied_L_", "pied_R_")
    body, order = _body(walk, feet), [2, 1, 0] if words[0][0] in "gp" else [0, 1, 2]
    for i, foot in enumerate(feet):
        body |= {f"{foot}{n}{end}": walk.rpy[:, i, k] for n, k in zip(words, order, strict=True)}
    file = guess_file(_written(tmp_path / "gang.csv", body))
    body_log = body_of(replace(file, text=replace(file.text, above=(line,))))
    assert body_log is not None
    found = body_entries(body_log.file)
    for axis, k in (("roll", 0), ("pitch", 1), ("yaw", 2)):
        entry = found[f"right_foot_{axis}_rad"]
        assert entry.column is not None
        assert entry.column.column == f"pied_R_{words[order.index(k)]}{end}"
        assert (entry.sure == "guess") == bool(whys)
        assert whys in entry.why


@pytest.mark.parametrize("by_columns", [True, False])
def test_nine_numbers_in_a_row_are_a_matrix_and_no_quaternion(
    tmp_path: Path, by_columns: bool
) -> None:
    walk = Walk()
    body = _body(walk)
    for i, foot in enumerate(("SohleLi_", "SohleRe_")):
        turned = Rotation.from_euler("xyz", walk.rpy[:, i]).as_matrix()
        nine = (turned.transpose(0, 2, 1) if by_columns else turned).reshape(-1, 9).T
        body |= {f"{foot}Rot[{k}]": v for k, v in enumerate(nine)}
    file = guess_file(_written(tmp_path / "m.csv", body))
    lines = ("Rot[0..8] a forgatási mátrix OSZLOPONKÉNT",) if by_columns else ()
    entries = _entries(replace(file, text=replace(file.text, above=lines)))
    assert entries["left_foot_r31"] == ("SohleLi_Rot[2]" if by_columns else "SohleLi_Rot[6]")
    assert "left_foot_qw" not in entries


def test_vectors_and_quaternions_that_are_numbered_from_one(tmp_path: Path) -> None:
    walk = Walk()
    one_to = {"x": "1", "y": "2", "z": "3"}
    log = {"Time": walk.t}
    log |= {f"CoM_{one_to[k[-1]]}": v for k, v in _xyz("", walk.com).items()}
    log |= {f"CoMAcc_{one_to[k[-1]]}": v for k, v in _xyz("", walk.acc).items()}
    share = (1 - walk.air) / np.maximum((1 - walk.air).sum(axis=1), 1)[:, None]
    for i, foot in enumerate("LR"):
        four = np.roll(Rotation.from_euler("xyz", walk.rpy[:, i]).as_quat(), 1, axis=1)
        log |= {f"{foot}AnklePos_{j + 1}": walk.feet[:, i, j] for j in range(3)}
        log |= {f"{foot}AnkleQuat_{j + 1}": four[:, j] for j in range(4)}
        force = 40.0 * (walk.acc + np.array([0.0, 0.0, 9.81])) * share[:, [i]]
        log |= {f"{foot}_F{k}": v for k, v in _xyz("", force).items()}
        log |= {f"{foot}_T{k}": 0.01 * v for k, v in _xyz("", force).items()}
    columns = _columns(_parts([_written(tmp_path / "walk.csv", log)])["cells"].plan)
    for i, side in enumerate(("left", "right")):
        assert columns[f"{side}_foot_qw"] == f"{'LR'[i]}AnkleQuat_1"
        assert columns[f"{side}_foot_z_m"] == f"{'LR'[i]}AnklePos_3"
    assert columns["com_acc_y_mps2"] == "CoMAcc_2"


def test_topics_of_a_body_a_rate_by_itself_and_zeros_with_a_row_for_each_foot(
    tmp_path: Path,
) -> None:
    walk = Walk()
    rate = {f"angular.{a}": walk.rate[:, i] for i, a in enumerate("xy")}
    paths = [
        _topic(tmp_path / "est_centroidal_momentum_rate.csv", walk.t, rate),
        _topic(tmp_path / "est_com.csv", walk.t,
               _xyz("position.", walk.com) | _xyz("acceleration.", walk.acc)),
    ]  # fmt: skip
    for i, foot in enumerate(("left", "right")):
        paths.append(_topic(tmp_path / f"est_{foot}_sole.csv", walk.t,
                            _xyz("pose.position.", walk.feet[:, i])))  # fmt: skip
        cells = {f"data_{k}": walk.counts(i, k) for k in range(3)}
        paths.append(_topic(tmp_path / f"cells_{foot}.csv", walk.t, cells))
    rows = [{"foot": foot, **{f"data_{k}": 500 + 40 * k for k in range(3)}}
            for foot in ("left", "right")]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "zero_in_air.csv", index=False)
    found = _parts([*paths, tmp_path / "zero_in_air.csv"])
    motion, zeros = _columns(found["body"].plan), _columns(found["zeros"].plan)
    assert motion["angmom_rate_x_nm"] == "est_centroidal_momentum_rate.angular.x"
    assert motion["com_x_m"] == "position.x"
    ends = {name: column for name, column in zeros.items() if name.endswith("data_2_counts")}
    assert ends == {
        "left_data_2_counts": "left.data_2", "right_data_2_counts": "right.data_2",
    }  # fmt: skip


def test_inspection_sheets_by_serial_number_read_up_and_down(tmp_path: Path) -> None:
    """A letter and decimals are no hexadecimal reading, and both readings are of one cell."""
    walk, paths = Walk(), []
    names = {f"{'BJ'[foot]}{211 + 3 * cell + 129 * foot}": (foot, cell)
             for foot in (0, 1) for cell in range(3)}  # fmt: skip
    for foot, called in enumerate(("bal", "jobb")):
        rows = [
            {"Gyári szám": name, "Etalon tömeg [kg]": kg,
             "Kijelzett felfelé [kg]": round(0.1 * cell + 1.01 * kg, 3),
             "Kijelzett lefelé [kg]": round(0.1 * cell + 1.01 * kg + 0.002 * kg % 0.007, 3),
             "Minősítés": "MF"}
            for name, (at, cell) in names.items() if at == foot for kg in (0, 2, 5, 10, 20)
        ]  # fmt: skip
        path = tmp_path / f"lap_{called}.csv"
        pd.DataFrame(rows).to_csv(path, index=False)
        paths.append(path)
    cells = {n: 0.1 * c + 1.01 * walk.cells[:, f, c] / 9.81 for n, (f, c) in names.items()}
    paths += [
        _written(tmp_path / "analog.csv", {"Zeit [s]": walk.t, **cells}),
        _written(tmp_path / "body.csv", _body(walk)),
    ]  # fmt: skip
    parts, others = parts_of([guess_file(path) for path in paths])
    assert not others
    benches = [part.plan for part in parts if part.plan.role == "weights"]
    assert [[*plan.wide] for plan in benches] == [["1", "2"]] * 2
    assert benches[0].wide_into == "repeat"
    read = benches[0].wide["2"]["counts"].column
    assert read is not None
    assert read.column == "Kijelzett lefelé [kg]"
    assert benches[1].entries["channel"].names == {
        "J340": "right_340", "J343": "right_343", "J346": "right_346",
    }  # fmt: skip
    stream = next(part.plan for part in parts if part.plan.role == "cells")
    assert {*stream.channels} == {c for plan in benches for c in plan.channels}


def _suspension(path: Path, legs: tuple[str, ...], rows: int, *, stands: bool) -> Path:
    """Four runs of one orientation each; transducers along the body's axes turn with their legs."""
    rng = np.random.default_rng(3)
    lines = []
    for run, down in enumerate(([0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0]), 1):
        four = Rotation.align_vectors([[0, 0, -1]], [down])[0].as_quat()
        for k in range(rows):
            line = [run, 0.1 * k, *four]
            for i in range(len(legs)):
                angle = (-1) ** i * 1.4 * np.sin(4 * np.pi * k / rows)
                turn = Rotation.from_euler("y", angle).inv()
                load = 1 + (0.5 * np.sin(k + i) if stands else 0.0)
                force = load * turn.apply(WEIGHT_N * np.array(down))
                six = np.hstack([force, np.cross(COM_M, force)]) + OFFSET
                line += [angle, *(six + rng.normal(0, [0.03] * 3 + [0.003] * 3))]
            lines.append(line)
    names = ["Run", "Time_s", "Body_qx", "Body_qy", "Body_qz", "Body_qw"]
    for leg in legs:
        names += [f"{leg}_Phase_rad", *(f"{leg}_{axis}" for axis in AXES)]
    pd.DataFrame(lines, columns=names).round(5).to_csv(path, index=False)
    return path


@pytest.mark.parametrize("stands", [False, True])
def test_legs_that_turn_with_their_transducers_hang(tmp_path: Path, stands: bool) -> None:
    """Forces of one size each, in four runs, are weights; no robot that stands carries so."""
    log = _suspension(tmp_path / "s.csv", ("FL", "FR", "HL", "HR"), 200, stands=stands)
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert (plan.command == "hang-calib") is not stands
    if not stands:
        assert plan.ready
        assert sum('turns_about = "+y"' in table for table in plan.robot) == 4


def test_hanging_of_transducers_that_turn_with_their_legs(tmp_path: Path, run: Run) -> None:
    log, recipe = _suspension(tmp_path / "s.csv", ("L", "R"), 60, stands=False), tmp_path / "r.toml"
    assert run("init", log, "-o", recipe).exit_code == 0
    assert recipe.read_text(encoding="utf-8").count("turns_about") == 2
    done = run("hang-calib", "--recipe", recipe, "--no-pictures", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.err
    found = read_record(ParametersRecord, tmp_path / "out" / "parameters.json").parameters
    for leg in ("left", "right"):
        weight = found[f"{leg}.weight"]
        assert weight.sd is not None
        assert abs(weight.value - WEIGHT_N) < 4 * weight.sd
        offset = found[f"{leg}.offset_fx"]
        assert offset.sd is not None
        assert abs(offset.value - OFFSET[0]) < 4 * offset.sd


def test_poses_have_the_legs_names_of_the_hanging() -> None:
    """Words ``lf`` and ``rh`` in the hanging are the legs fl and hr of the poses' columns."""
    file = FileGuess(Path("a.csv"), TextGuess(Layout()), (), 0)
    words = ColumnGuess("leg", NameGuess("label"), None, "sure", "", words=("lf", "rh"))
    hung = LogPlan(file, "", "", "sure", "hang-calib", "hang", {"leg": of(words)})
    table = "[robot.legs.{}]\n# position_m = [0.0, 0.0, 0.0]"
    poses = replace(
        hung, command="pose-calib", role="poses", entries={}, wide={"fl": {}, "hr": {}},
        robot=(table.format("fl"), table.format("hr")),
    )  # fmt: skip
    parts = under_hung_names([Part(hung, (), ""), Part(poses, (), "")])
    assert [*parts[1].plan.wide] == ["lf", "rh"]
    assert parts[1].plan.robot == (table.format("lf"), table.format("rh"))

"""Logs as newcomers keep them: which cell a weight lay on, legs in files of their own, letters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.flight import with_flight_angles
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.recipe_text import next_step
from footcal_cli.sniff.several import parts_of

CELLS = ("vorne links", "vorne rechts", "mitte links", "mitte rechts")
LOADS_G = (0, 500, 1000, 2000, 5000)
ATTITUDES_DEG = np.array(
    [[0, 0, 0], [40, 0, 10], [-35, 20, 30], [10, 50, -20], [80, -10, 60], [-90, 5, 0], [170, 3, 20],
     [20, -60, 5]]
)  # fmt: skip
AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")


def one_at_a_time(path: Path, words: tuple[str, ...] | None, columns: tuple[str, ...]) -> Path:
    """Weights on one of four cells at a time, all of them read, and the words of the loaded one."""
    rng = np.random.default_rng(1)
    head = ["Zelle", "Gewicht [g]", *columns] if words else ["Gewicht [g]", *columns]
    rows = [";".join(head)]
    for i in range(len(CELLS)):
        for load in LOADS_G:
            read = 1000.0 * np.arange(1, 5) + rng.normal(0, 4, 4)
            read[i] += (4.0 + 0.1 * i) * load
            numbers = [f"{v:.1f}".replace(".", ",") for v in read]
            rows.append(";".join(([words[i]] if words else []) + [str(load), *numbers]))
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("words", "columns"),
    [
        (CELLS, tuple(f"ADC {cell}" for cell in CELLS)),  # the end of the column's name
        (("FL", "FR", "ML", "MR"), tuple(f"ADC {cell}" for cell in CELLS)),  # where it sits
        (("Nord", "Ost", "Süd", "West"), ("ADC1", "ADC2", "ADC3", "ADC4")),  # the readings say it
    ],
)
def test_the_loaded_cell_by_its_words_or_by_its_readings(
    tmp_path: Path, words: tuple[str, ...], columns: tuple[str, ...]
) -> None:
    plan = plan_of(guess_file(one_at_a_time(tmp_path / "a.csv", words, columns)))
    assert plan is not None
    assert plan.ready
    read = {cell: own["counts"].column for cell, own in plan.wide.items()}
    assert {w: c.column for w, c in read.items() if c} == dict(zip(words, columns, strict=True))
    assert all(own["load_n"].only_where == {"Zelle": w} for w, own in plan.wide.items())


def test_words_that_readings_contradict_are_no_cells(tmp_path: Path) -> None:
    words = ("Nord", "Nord", "Süd", "Süd")  # two cells move under each word
    plan = plan_of(guess_file(one_at_a_time(tmp_path / "a.csv", words, ("A1", "A2", "A3", "A4"))))
    assert plan is not None
    assert not plan.ready


def test_weights_on_one_cell_after_another_without_a_word_are_asked_for(tmp_path: Path) -> None:
    plan = plan_of(guess_file(one_at_a_time(tmp_path / "a.csv", None, ("A1", "A2", "A3", "A4"))))
    assert plan is not None
    assert any("no column says on which" in blank.why for blank in plan.blanks)
    assert not plan.ready
    assert not plan.warnings


def test_cells_that_all_carry_the_weight_are_not_asked_for(tmp_path: Path) -> None:
    rows = ["Gewicht [g];fl;fr", *(f"{m};{100 + 4 * m};{300 + 5 * m}" for m in LOADS_G)]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    plan = plan_of(guess_file(tmp_path / "a.csv"))
    assert plan is not None
    assert plan.ready


def hung(
    path: Path, turn: Rotation, names: tuple[str, str, str] = ("roll", "pitch", "yaw")
) -> Path:
    """One leg of 8 N under a transducer that is turned in the body, the body in eight attitudes."""
    rng = np.random.default_rng(2)
    rows = [",".join(["time", *(f"{n} (deg)" for n in names), *AXES])]
    for k, angles in enumerate(ATTITUDES_DEG):
        frame = Rotation.from_euler("xyz", angles, degrees=True) * turn
        force = frame.inv().apply([0.0, 0.0, -8.0])
        wrench = np.concatenate([force, np.cross([0.06, 0.0, -0.08], force)])
        for i in range(20):
            noisy = wrench + rng.normal(0, [0.02] * 3 + [0.001] * 3)
            numbers = [0.01 * i + 5 * k, *angles, *noisy]
            rows.append(",".join(f"{v:.4f}" for v in numbers))
    path.write_text("\n".join(rows) + "\n")
    return path


def test_legs_in_files_of_their_own_are_mounted_each_in_its_way(tmp_path: Path) -> None:
    turns = {"LF": 0.0, "LH": 0.0, "RF": np.pi, "RH": np.pi / 2}
    paths = [
        hung(tmp_path / f"leg_{leg}.csv", Rotation.from_euler("z", turn))
        for leg, turn in turns.items()
    ]
    ((part,), others) = parts_of([guess_file(path) for path in paths])
    assert not others
    assert part.plan.kind.startswith("4 six-axis transducers")
    assert part.plan.entries["leg"].file_name is not None
    text = "\n".join(part.plan.robot)
    for leg, yaw in {"fl": "0", "hl": "0", "fr": "3.1416", "hr": "1.5708"}.items():
        _, _, table = text.partition(f"[robot.legs.{leg}]")
        assert f"rotation_rpy_rad = [0, 0, {yaw}]" in table.partition("[robot.")[0]


def test_phi_theta_psi_are_an_attitude_and_one_letter_is_not(tmp_path: Path) -> None:
    file = guess_file(hung(tmp_path / "a.csv", Rotation.identity(), ("phi", "theta", "psi")))
    assert [c.name.axis for c in file.of("angle")] == ["roll", "pitch", "yaw"]
    alone = [c for c in file.columns if c.column == "phi (deg)"]
    plain = [c.as_quantity("unknown", "guess", "") for c in alone]
    assert with_flight_angles(plain) == plain
    named = guess_file(hung(tmp_path / "b.csv", Rotation.identity()))
    assert with_flight_angles(list(named.columns)) == list(named.columns)


def test_cells_of_a_topic_are_readings_and_not_loads() -> None:
    for name in ("/left_foot/load_cells/data.fl", "left load cells fl", "/left/loadcells/fl"):
        guess = name_guess(name)
        assert (guess.quantity, guess.address) == ("reading", "left_fl")


def test_weights_and_a_walk_that_holds_its_body_are_two_steps(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    cells = [f"{side}_{place}" for side in ("left", "right") for place in ("fl", "fr", "rl", "rr")]
    rows = [f"{c},{m},{900 + 4 * m + rng.normal(0, 3):.0f}" for c in cells for m in LOADS_G]
    (tmp_path / "weights.csv").write_text("\n".join(["cell,weight_g,raw", *rows]) + "\n")
    topics = [f"/{c.replace('_', '_foot/load_cells/data.')}" for c in cells]
    motion = [f"/robot_state/com/position/{a}" for a in "xyz"]
    t = 0.01 * np.arange(400)
    read = 900 + 2000 * rng.random((400, 8)).cumsum(axis=0) / np.arange(1, 401)[:, None]
    com = np.column_stack([0.06 * t, 0.02 * np.sin(t), 0.27 + 0.0 * t])
    lines = [",".join(["%time", *topics, *motion])]
    lines += [
        ",".join([f"{1e9 * (1.7e9 + at):.0f}", *(f"{v:.0f}" for v in r), *(f"{v:.5f}" for v in c)])
        for at, r, c in zip(t, read, com, strict=True)
    ]
    (tmp_path / "walk.csv").write_text("\n".join(lines) + "\n")
    parts, others = parts_of([guess_file(tmp_path / n) for n in ("weights.csv", "walk.csv")])
    assert not others
    assert [part.plan.role for part in parts] == ["weights", "cells"]
    said = next_step(parts, "--recipe a.toml")
    assert said.startswith("footcal offline-fit --recipe a.toml; after it online-replay")
    assert "where the cells sit" in said
    assert "newtons a count" not in said  # the weights say it

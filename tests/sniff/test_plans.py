"""What logs of weights, transducers and feet are taken for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.parameters import FloatArray
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of, why_not
from footcal_cli.sniff.file_names import alike_part, called
from footcal_cli.sniff.groups import channel_names, readings
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.numbered import numbered
from footcal_cli.sniff.several import parts_of


def test_a_displacement_or_a_temperature_is_no_reading(tmp_path: Path) -> None:
    """They follow the load, or rise evenly: a calibration of them would look good."""
    log = tmp_path / "a.csv"
    lines = [f"{i / 10};{i};{i / 900:.4f};{22 + i / 100};{i * 0.7 + 3:.3f}" for i in range(60)]
    log.write_text("t [s];F [N];Weg [mm];T [°C];DMS [V]\n" + "\n".join(lines) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert [
        e.column.column for n, e in plan.entries.items() if n.endswith("counts") and e.column
    ] == ["DMS [V]"]


@pytest.mark.parametrize(
    ("names", "how"),
    [("M,d,e", "guess"), ("left_fl,left_fr,left_rl", "likely"), ("F1 [N],F2 [N],F3 [N]", "likely")],
)
def test_numbers_that_nothing_calls_readings_are_a_guess(
    tmp_path: Path, names: str, how: str
) -> None:
    log = tmp_path / "a.csv"
    values = np.random.default_rng(0).normal(3.0, 1.0, size=(60, 3))
    log.write_text(names + "\n" + "\n".join(",".join(f"{v:.4f}" for v in r) for r in values) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.sure == how
    doubted = [b for b in plan.blanks if "that its numbers are readings" in b.why]
    assert len(doubted) == (how == "guess")


def test_siblings_of_a_reading_are_readings(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text(
        "load_N,A,B\n" + "\n".join(f"{i},{9 * i * i % 31},{7 * i % 5}" for i in range(9)) + "\n"
    )
    assert list(channel_names(readings(guess_file(log)))) == ["a", "b"]


def test_names_of_files_that_say_a_load_in_any_unit(tmp_path: Path) -> None:
    logs = []
    for name in ("cell2_zero.csv", "cell2_8oz.csv", "cell2_16oz.csv"):
        logs.append(tmp_path / name)
        logs[-1].write_text("reading\n" + "\n".join(f"{7000 + 3 * i % 7}" for i in range(9)) + "\n")
    part = alike_part([guess_file(log) for log in logs])
    assert part is not None
    load = part.plan.entries["load_n"]
    assert load.unit == "oz"
    assert set(load.names.values()) == {"0", "8", "16"}


def test_logs_named_alike_are_called_after_their_folders(tmp_path: Path) -> None:
    paths = [tmp_path / "0g" / "log.csv", tmp_path / "500g" / "log.csv"]
    assert called(paths) == ["0g/log.csv", "500g/log.csv"]
    assert called(paths[:1]) == ["log.csv"]


def test_a_cell_that_carries_nothing_is_left_out_and_said(tmp_path: Path) -> None:
    rng, log = np.random.default_rng(1), tmp_path / "a.csv"
    load = np.repeat([0.0, 1, 2, 5], 5)
    noise = rng.normal(0, 1e-3, (2, load.size))
    rows = zip(load, 3 * load + noise[0], noise[1], strict=True)
    log.write_text("load_kg,ch1_V,ch2_V\n" + "".join(f"{a},{b:.6f},{c:.6f}\n" for a, b, c in rows))
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.channels == ("cell_1",)
    assert any("ch2_V: left out" in warning for warning in plan.warnings)


def test_the_column_that_names_the_loaded_cell(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    lines = [f"{on},{kg},{7 + kg * (on == 'NE')},{5 + kg * (on == 'S')}"
             for on in ("NE", "S") for kg in (0, 1, 4, 2, 9)]  # fmt: skip
    log.write_text("on,load_kg,NE,S\n" + "\n".join(lines) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.channels == ("NE", "S")
    assert plan.wide["S"]["load_n"].only_where == {"on": "S"}


def test_cells_below_each_other_without_loads_are_not_one_cell(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    lines = [f"{5 * i},{foot},{at},{8_300_000 + 7 * i % 5}"
             for i in range(40) for foot in ("left", "right") for at in ("fl", "fr")]  # fmt: skip
    log.write_text("ms,foot,corner,raw\n" + "\n".join(lines) + "\n")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.channels == ("left_fl", "left_fr", "right_fl", "right_fr")
    assert plan.entries["time_s"].unit == "ms"
    # without stamps, and with samples lost, nothing says which rows belong together
    rest = [x.partition(",")[2] for i, x in enumerate(lines) if i not in (2, 9, 22)]
    log.write_text("foot,corner,raw\n" + "\n".join(rest) + "\n")
    found = why_not(guess_file(log))
    assert found is not None
    assert "left_fl_counts" in found[1]


def test_transducers_that_carry_one_weight_together_stand(tmp_path: Path) -> None:
    share = np.repeat([0.5, 0.3, 0.7], 40)
    rng, log = np.random.default_rng(2), tmp_path / "a.csv"
    parts = [
        np.column_stack([*rng.normal(0, 0.5, (2, share.size)), 600 * part, *rng.normal(
            0, 5, (3, share.size))]) for part in (share, 1 - share)
    ]  # fmt: skip
    names = [f"FP{i}_{a}" for i in (1, 2) for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    np.savetxt(log, np.hstack(parts), "%.4f", ",", header=",".join(names), comments="")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.command == "static-init"
    np.savetxt(log, np.hstack([parts[0], parts[0]]), "%.4f", ",", header=",".join(names),
               comments="")  # fmt: skip
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.command == "hang-calib"


def test_gravity_among_numbers_without_names(tmp_path: Path) -> None:
    rng, log = np.random.default_rng(3), tmp_path / "a.txt"
    up = np.repeat(rng.normal(0, 1, (12, 3)), 20, axis=0)
    up *= 9.81 / np.linalg.norm(up, axis=1, keepdims=True)
    table = np.column_stack([0.01 * np.arange(len(up)), rng.normal(0, 1, (len(up), 2)), up])
    np.savetxt(log, table, "%.5f")
    found = numbered(guess_file(log)).of("acceleration")
    assert [c.column for c in found] == ["column_4", "column_5", "column_6"]


def _written(folder: Path, name: str, text: str) -> FileGuess:
    log = folder / name
    log.write_text(text, encoding="utf-8")
    return guess_file(log)


def test_a_table_of_steps_says_the_loads(tmp_path: Path) -> None:
    readings_of = "step,raw\n" + "".join(f"{i // 5},{8_000 + i * i % 7}\n" for i in range(20))
    read = _written(tmp_path, "read.csv", readings_of)
    steps = _written(tmp_path, "steps.csv", "step,load_kg\n0,0\n1,1\n2,2.5\n3,5\n")
    for order in ((read, steps), (steps, read)):
        (part,), others = parts_of(order)
        assert others == []
        load = part.plan.entries["load_n"]
        assert (load.unit, load.names["2"]) == ("kg", "2.5")
    unknown = _written(tmp_path, "few.csv", "step,load_kg\n0,0\n1,1\n")
    parts, _ = parts_of([read, unknown])
    assert not any(
        "2" in p.plan.entries["load_n"].names for p in parts if "load_n" in p.plan.entries
    )


def test_what_a_display_read_under_weights_that_the_names_say(tmp_path: Path) -> None:
    logs = [
        _written(tmp_path, f"cal_{w}lb.csv", "Load (lb)\n" + "".join(
            f"{w * 0.98 + 0.01 * (i % 3):.3f}\n" for i in range(9)))
        for w in (0, 2, 5)
    ]  # fmt: skip
    part = alike_part(logs)
    assert part is not None
    assert part.plan.entries["load_n"].unit == "lb"
    assert part.plan.entries["counts"].unit == "lb"


def test_places_are_no_torques_and_two_arms_have_two_attitudes(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    names, table = ["TX (mm)"], [rng.normal(500, 1, 240)]
    for side in ("left", "right"):
        rotation = Rotation.random(12, random_state=rng)
        down = np.repeat(rotation.inv().apply([0, 0, -1.0]), 20, axis=0)
        force = 9.0 * down + rng.normal(0, 0.01, down.shape)
        names += [f"{side}_wrist_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz", *(
            f"q{x}" for x in "xyzw"))]  # fmt: skip
        quaternion = np.repeat(rotation.as_quat(), 20, axis=0)
        table += [*force.T, *np.cross([0, 0, 0.05], force).T, *quaternion.T]
    log = tmp_path / "arms.csv"
    np.savetxt(log, np.column_stack(table), "%.6f", ",", header=",".join(names), comments="")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.command == "hang-calib"
    assert {name: w["body_qw"].column.column for name, w in plan.wide.items() if w["body_qw"].column
            } == {"left": "left_wrist_qw", "right": "right_wrist_qw"}  # fmt: skip
    assert plan.file.of("force")[0].column == "left_wrist_fx"


def test_a_known_wrench_is_no_load_on_six_cells(tmp_path: Path) -> None:
    rng, log = np.random.default_rng(6), tmp_path / "rig.csv"
    put = rng.normal(0, 50, (40, 6))
    axes = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    names = [*(f"{a} applied" for a in axes), *(f"bridge {i} [mV/V]" for i in range(6))]
    table = np.hstack([put, put @ rng.normal(0, 0.01, (6, 6))])
    np.savetxt(log, table, "%.6f", ",", header=",".join(names), comments="")
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.options == ("known_wrench = true",)
    assert plan.entries["known_tx_nm"].unit == "N*m"
    assert len(plan.channels) == 6


LOAD_N = np.repeat([0.0, 10, 20, 50], 6)
RAW = np.round(2e3 * LOAD_N + np.tile([7.0, 3, 5, 1, 9, 2], 4))


def _table(folder: Path, names: str, *columns: FloatArray) -> FileGuess:
    text = "\n".join(",".join(f"{v:g}" for v in row) for row in zip(*columns, strict=True))
    return _written(folder, "a.csv", f"{names}\n{text}\n")


@pytest.mark.parametrize("names", ["setpoint_N,actual_N,raw", "target_N,applied load (N),raw"])
def test_the_measured_load_counts_not_the_one_asked_for(tmp_path: Path, names: str) -> None:
    """A press that gives 7 % more than it is asked for: scales were 7 % too small, accepted."""
    plan = plan_of(_table(tmp_path, names, LOAD_N, 1.07 * LOAD_N, RAW))
    assert plan is not None
    load = plan.entries["load_n"].column
    assert load is not None
    assert load.column == names.split(",")[1]
    alone = plan_of(_table(tmp_path, "target_N,raw", LOAD_N, RAW))
    assert alone is not None
    assert alone.entries["load_n"].column is not None


def test_weights_added_one_by_one_are_no_loads(tmp_path: Path) -> None:
    file = _table(tmp_path, "added_kg,raw", LOAD_N, RAW)
    assert plan_of(file) is None
    found = why_not(file)
    assert found is not None
    assert "total load" in found[1]


def test_units_that_disagree_are_asked_for(tmp_path: Path) -> None:
    """The row of units was believed: kilograms in newtons, 9.8 times too small, good."""
    rows = "\n".join(f"{a:g},{b:g}" for a, b in zip(LOAD_N, RAW, strict=True))
    plan = plan_of(_written(tmp_path, "a.csv", f"Load (kg),Reading\nN,-\n{rows}\n"))
    assert plan is not None
    assert not plan.ready
    plan = plan_of(_written(tmp_path, "a.csv", f"Load (kg),Reading\nkg,-\n{rows}\n"))
    assert plan is not None
    assert plan.ready


def test_weights_and_repeats_in_names_of_files(tmp_path: Path) -> None:
    logs = [
        _written(tmp_path, f"fl_{w}g_run{i}.csv", "raw\n" + "\n".join(
            f"{7000 + w + 3 * j % 7}" for j in range(9)) + "\n")
        for w in (0, 500, 1000) for i in (1, 2)
    ]  # fmt: skip
    part = alike_part(logs)
    assert part is not None
    load = part.plan.entries["load_n"]
    assert load.unit == "kg"
    assert sorted(load.names.values()) == ["0", "0", "0.5", "0.5", "1", "1"]


_CORNERS = {"front left": (9e4, 21e3), "front right": (-4e4, 203e2), "rear left": (12e3, 221e2),
            "rear right": (15e4, 195e2)}  # fmt: skip


def _scale(folder: Path, names: str, row: str) -> FileGuess:
    """Weights on four cells below each other, by true zeros and slopes; noise of 40 counts."""
    rng, lines = np.random.default_rng(4), [names]
    for i, (corner, (zero, slope)) in enumerate(_CORNERS.items(), 1):
        for run in (1, 2):
            lines += [
                row.format(corner=corner, i=i, run=run, who=("anna", "ben")[run - 1], kg=kg,
                           raw=round(zero + slope * kg + rng.normal(0, 40)))
                for kg in (0, 1, 2, 5, 10, 5, 2)
            ]  # fmt: skip
    return _written(folder, "luggage.csv", "\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("names", "row", "column"),
    [
        ("device,who,corner,load_kg,raw", "LS-50,{who},{corner},{kg},{raw}", "corner"),
        ("pos,load_kg,raw", "{i},{kg},{raw}", "pos"),
        ("position,run,load_kg,raw", "{corner},{run},{kg},{raw}", "position"),
    ],
)
def test_the_column_whose_groups_are_straight_is_the_cell(
    tmp_path: Path, names: str, row: str, column: str
) -> None:
    plan = plan_of(_scale(tmp_path, names, row))
    assert plan is not None
    assert plan.entries["channel"].column is not None
    assert plan.entries["channel"].column.column == column
    assert len(plan.channels) == len(_CORNERS)


@pytest.mark.parametrize(("zero", "slope"), [(0.0, 0.0), (500.0, 0.0), (0.0, 60.0)])
def test_places_on_one_cell_and_other_tares_are_no_cells(
    tmp_path: Path, zero: float, slope: float
) -> None:
    """Without a load a place says nothing; another tare moves no slope."""
    rng = np.random.default_rng(5)
    lines = [
        f"{i},{kg},{8e4 + zero * i + (21e3 + slope * i) * kg + rng.normal(0, 40):.0f}"
        for i in (1, 2, 3, 4) for kg in (0, 1, 2, 5, 10, 5, 2)
    ]  # fmt: skip
    plan = plan_of(_written(tmp_path, "a.csv", "pos,load_kg,raw\n" + "\n".join(lines) + "\n"))
    assert plan is not None
    assert len(plan.channels) == 1


def test_an_inertial_unit_beside_cells_is_neither_foot_nor_cell(tmp_path: Path) -> None:
    """Xsens' layout: rates of turn are no readings, its clock counts tenths of a millisecond."""
    rng = np.random.default_rng(6)
    feet = [f"{side}F_{place}" for side in "LR" for place in ("FL", "FR", "RL", "RR")]
    head = ["PacketCounter", "SampleTimeFine", *(f"{s}_{a}" for s in ("Acc", "Gyr") for a in "XYZ")]
    lines = [
        ",".join(map(str, [i, 125 * i + 1234567, *rng.normal(0, 1, 6), *rng.integers(0, 9999, 8)]))
        for i in range(80)
    ]
    text = "// UpdateRate,80.0Hz\n" + ",".join([*head, *feet]) + "\n" + "\n".join(lines) + "\n"
    file = _written(tmp_path, "run3_imu.csv", text)
    assert file.rate_hz == pytest.approx(80.0)
    plan = plan_of(file)
    assert plan is not None
    places = ("fl", "fr", "rl", "rr")
    assert plan.channels == tuple(f"{side}_{p}" for side in ("left", "right") for p in places)
    assert plan.entries["time_s"].factor == pytest.approx(0.1)


@pytest.mark.parametrize("names", ["micros,raw", "clock,raw"])
def test_a_counter_that_wraps_and_counts_are_no_seconds_and_nanoseconds(
    tmp_path: Path, names: str
) -> None:
    """A 32-bit counter of microseconds near its end looks like seconds since 1970."""
    us = (4_280_000_000 + 12_500 * np.arange(2256)) % 2**32
    counts = np.random.default_rng(7).normal(8.3e6, 40.0, us.size).round()
    rows = "".join(f"{t},{y:.0f}\n" for t, y in zip(us, counts, strict=True))
    file = _written(tmp_path, "teensy.csv", f"{names}\n{rows}")
    plan = plan_of(file)
    assert plan is not None
    assert plan.channels == ("raw",)
    assert plan.entries["time_s"].wraps_at == 2**32
    ros = 1_700_000_000.0 + 0.0125 * np.arange(400)
    stamps = "".join(
        f"{int(t)},{1e9 * (t % 1):.0f},{y:.0f}\n" for t, y in zip(ros, counts, strict=False)
    )
    file = _written(tmp_path, "ros.csv", f"a,b,raw\n{stamps}")
    assert file.rate_hz == pytest.approx(80.0, rel=1e-3)

"""Readers and guesses that logs of the sixteenth corpus asked for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.formats.detect import open_source
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of, why_not
from footcal_cli.sniff.plan import times
from footcal_cli.sniff.said_weights import sums_of
from footcal_cli.sniff.sides import orientation_in
from footcal_cli.tables.foreign import cards
from footcal_cli.tables.registers import thirty_two_bits
from tests.conftest import Run


@pytest.mark.parametrize(
    ("texts", "loads", "unit"),
    [
        (["empty", "1 lb", "1 lb + 2.5 lb"], [0, 1, 3.5], "lb"),
        (["no load", "2 x 500 g", "1 kg and 250 g"], [0, 1, 1.25], "kg"),
        (["5 kg cell, 1 kg", "empty"], None, ""),
        (["A", "B"], None, ""),
        (["-1 kg", "2 kg"], None, ""),
    ],
)
def test_weights_in_words(texts: list[str], loads: list[float] | None, unit: str) -> None:
    found = sums_of(texts)
    if loads is None:
        assert found is None
        return
    assert found is not None
    assert found[1] == unit
    assert [found[0][text] for text in texts] == pytest.approx(loads)


def test_two_registers_are_one_signed_number() -> None:
    numbers = np.array([0, 1, 65535, 65536, 8_388_607, -1, -65536, -8_388_608])
    high, low = (numbers >> 16) & 0xFFFF, numbers & 0xFFFF
    assert np.array_equal(thirty_two_bits(high.astype(float), low.astype(float)), numbers)


def test_a_recipe_reads_two_registers(tmp_path: Path, run: Run) -> None:
    load = np.repeat([0, 5, 10, 20, 40.0], 3)
    read = np.round(-70_000 + 12_345 * load).astype(int)
    lines = [f"{x:g},{n >> 16 & 0xFFFF},{n & 0xFFFF}" for x, n in zip(load, read, strict=True)]
    (tmp_path / "m.csv").write_text("\n".join(["load_N,hi,lo", *lines]) + "\n")
    recipe = tmp_path / "m.toml"
    assert run("init", tmp_path / "m.csv", "-o", recipe).exit_code == 0
    assert 'high_word = "hi"' in recipe.read_text()
    done = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out", "--quiet")
    assert done.exit_code == 0, done.err
    found = json.loads((tmp_path / "out/parameters.json").read_text())["parameters"]
    scale = next(p["value"] for name, p in found.items() if name.endswith(".scale"))
    assert scale == pytest.approx(1 / 12_345, rel=1e-9)
    (tmp_path / "m.csv").write_text("load_N,hi,lo\n0,0,70000\n1,1,5\n2,1,9\n")
    refused = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "two", "--quiet")
    assert refused.exit_code == 3
    assert "16 bits" in refused.err


def test_records_of_several_lines() -> None:
    text = "Bench 4\n\nNo: 1\nLoad: 500 g\nRaw = 7\n\n[next]\nNo: 2\nLoad: 1000 g\nRaw = 9\n"
    text += "---\nNo: 3\nLoad: 0 g\nRaw = 3\n"
    assert [one["Load"] for one in cards(text)] == ["500 g", "1000 g", "0 g"]
    assert cards("time,raw\n1,2\n") == []
    assert cards("raw: 1\nraw: 2\nraw: 3\nraw: 4\n") == [], "one value a line is a stream"


def test_lists_in_a_list_of_channels(tmp_path: Path) -> None:
    channels = [{"channel": i, "points": [{"kg": k, "raw": 10 * i + k} for k in (0, 1, 2)]}
                for i in (0, 1)]  # fmt: skip
    (tmp_path / "c.json").write_text(json.dumps({"date": "today", "channels": channels}))
    (stream,) = open_source(tmp_path / "c.json", "header")
    (chunk,) = stream.chunks()
    assert chunk["raw"].tolist() == [0, 1, 2, 10, 11, 12]
    assert chunk["channel"].tolist() == [0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize(
    ("word", "axis"),
    [
        ("nose down", "+x"), ("tail_down", "-x"), ("left side down", "+y"), ("feet up", "+z"),
        ("feet down", "-z"), ("right-up", "+y"), ("upstairs left", None), ("tool_down", None),
    ],
)  # fmt: skip
def test_sides_of_a_body(word: str, axis: str | None) -> None:
    assert orientation_in(word) == axis


def _written(path: Path, head: str, *columns: object) -> Path:
    table = np.column_stack([np.asarray(c, dtype=float) for c in columns])
    np.savetxt(path, table, "%.9g", ",", header=head, comments="")
    return path


def test_a_lever_that_changes_is_refused_and_one_length_is_not(tmp_path: Path) -> None:
    kg, cm = np.tile(np.repeat([0, 1, 2.0], 4), 2), np.repeat([10, 25.0], 12)
    log = guess_file(_written(tmp_path / "a.csv", "mass_kg,arm_cm,raw", kg, cm, 5 + 90 * kg * cm))
    found = why_not(log)
    assert found is not None
    assert "arm_cm" in found[0]
    log = guess_file(_written(tmp_path / "b.csv", "mass_kg,arm_cm,raw", kg, cm, 5 + 90 * kg))
    assert why_not(log) is None


def test_what_a_weight_weighs_goes_before_what_stands_on_it(tmp_path: Path) -> None:
    kg = np.repeat([0, 1, 2, 5.0], 3)
    grams = 1000 * kg * np.repeat([1, 1.01, 0.98, 1.02], 3)
    log = _written(tmp_path / "w.csv", "nominal_kg,actual_g,raw", kg, grams, 3 * grams)
    plan = plan_of(guess_file(log))
    assert plan is not None
    chosen = plan.entries["load_n"].column
    assert chosen is not None
    assert chosen.column == "actual_g"


def test_how_transducers_at_feet_are_turned(tmp_path: Path) -> None:
    """The mounting that the wrench was turned by, where the CoM accelerates along x and y."""
    rng, n = np.random.default_rng(3), 800
    t = np.arange(n) / 100
    acc = np.column_stack([np.sin(7 * t), 0.7 * np.cos(5 * t), 0.3 * np.sin(11 * t)])
    mount = Rotation.from_euler("y", -90, degrees=True)
    share = 0.5 + 0.4 * np.sin(3 * t)
    columns, names = [t], ["time_s"]
    for side, part in (("left", share), ("right", 1 - share)):
        force = 50 * part[:, None] * (acc + np.array([0, 0, 9.81])) + rng.normal(0, 1, (n, 3))
        wrench = np.hstack([mount.inv().apply(force), rng.normal(0, 0.1, (n, 3))])
        columns += list(wrench.T)
        names += [f"{side}_ankle_{a}" for a in ("fx", "fy", "fz", "tx", "ty", "tz")]
        place = np.tile([0, 0.1 if side == "left" else -0.1, 0.05], (n, 1))
        columns += [*place.T, *np.tile([0, 0, 0, 1.0], (n, 1)).T]
        names += [f"{side}_foot_{a}" for a in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    columns += [*np.tile([0, 0, 0.8], (n, 1)).T, *acc.T]
    names += [*(f"com_{a}" for a in "xyz"), *(f"com_acc_{a}" for a in "xyz")]
    plan = plan_of(guess_file(_written(tmp_path / "walk.csv", ",".join(names), *columns)))
    assert plan is not None
    assert len(plan.feet) == 2
    assert "transducer_rotation_rpy_rad = [0, -1.570796, 0]" in plan.mounting


def test_a_plate_keeps_its_number(tmp_path: Path, run: Run) -> None:
    """The fourth of four plates, and the second alone in an OpenSim table, are called so."""
    rng, n = np.random.default_rng(2), 400
    logs = []
    for number in (1, 2, 3, 4):
        force = rng.normal(0 if number < 4 else 700, 1, n)
        head = "time_s,force_z_n,cop_x_m,cop_y_m"
        places = (0.01 * rng.standard_normal(n), 0.01 * rng.standard_normal(n))
        log = _written(tmp_path / f"plate_{number}.csv", head, np.arange(n) / 100, force, *places)
        logs.append(log)
    recipe = tmp_path / "four.toml"
    assert run("init", *logs, "-o", recipe).exit_code == 0
    assert "[robot.feet.plate_4]" in recipe.read_text()
    head = "time," + ",".join(f"2_ground_force_{a}" for a in ("vx", "vy", "vz", "px", "py", "pz"))
    columns = [rng.normal(700 if i == 1 else 0, 1, n) for i in range(3)]
    columns += [0.01 * rng.standard_normal(n) for _ in range(3)]
    plan = plan_of(guess_file(_written(tmp_path / "o.csv", head, np.arange(n) / 100, *columns)))
    assert plan is not None
    assert "plate_2_fz_n" in plan.entries


@pytest.mark.parametrize(
    ("said", "rate_hz"),
    [
        ("press run, both channels sampled at 80 Hz", 80.0),
        ("1.2 kHz sampling, low-pass at 50 Hz", 1200.0),
        ("low-pass filter at 50 Hz", 100.0),
        ("sampled at 80 Hz, then logged at 10 Hz", 100.0),
    ],
)
def test_a_rate_in_a_sentence(said: str, rate_hz: float, tmp_path: Path) -> None:
    """A sampling rate above the table is taken; a filter's frequency, or two rates, are not."""
    log = tmp_path / "cell.csv"
    read = np.random.default_rng(0).integers(0, 900, 40)
    log.write_text("\n".join([f"# {said}", "a_counts,b_counts", *(f"{v},{2 * v}" for v in read)]))
    assert times(guess_file(log), needed=True)[1] == rate_hz

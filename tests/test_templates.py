"""Templates of recipes run: the command that each names, on a log as it describes, to the truth."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.spatial import rotations_of_rpy
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.conftest import Run
from tests.strangers.rigs import G, rows, settling, tool

Rng = np.random.Generator
NAO = [f"{side}Fsr{at}" for side in "LR" for at in ("FL", "FR", "RL", "RR")]


def serial(rng: Rng) -> str:
    """An HX711 with the weights typed between: 20 readings each."""
    lines = []
    for grams in (0, 500, 1000, 2000, 0):
        lines.append(f"weight {grams} g")
        counts = (grams / 1000 * G + 12.0) / -3.4e-5 + rng.normal(0, 30, 20)
        lines += [f"Reading: {c:.0f}" for c in counts]
    return "\n".join(lines)


def biped(rng: Rng) -> str:
    """A robot of 5.3 kg shifts its weight between feet whose cells all read 3 % low."""
    share = settling([0.5, 0.3, 0.7, 0.4, 0.6], 4, 50)
    load = 5.3 * G / 1.03 * np.repeat(np.column_stack([share, 1 - share]) / 4, 4, axis=1)
    data = load + rng.normal(0, 0.02, load.shape)
    return "\n".join([",".join(["time", *NAO]), *rows(np.arange(share.size) / 50, *data.T)])


def quadruped(rng: Rng) -> str:
    """A trot of 25 kg: diagonal pairs take turns."""
    t = np.arange(1000) / 200
    pair = 0.5 + 0.5 * np.sin(2 * np.pi * t)
    feet = 25 * G / 2 * np.column_stack([pair, 1 - pair, 1 - pair, pair])
    feet = feet + rng.normal(0, 1, feet.shape)
    names = ["timestamp", *(f"{leg}_FOOT_force" for leg in ("LF", "RF", "LH", "RH"))]
    stamps = [f"{1_700_000_000_000_000_000 + 5_000_000 * i}" for i in range(t.size)]
    return "\n".join(
        [",".join(names), *(f"{a},{b}" for a, b in zip(stamps, rows(*feet.T), strict=True))]
    )


def humanoid(rng: Rng) -> str:
    """60 kg on two ankles, feet apart by 0.2 m; the left transducer reads 8 N too much."""
    share = settling([0.5, 0.3, 0.7, 0.4, 0.6], 4, 100)
    names, data = ["t"], [np.arange(share.size) / 100]
    for side, part in (("l", share), ("r", 1 - share)):
        names += [f"{side}_{a}" for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
        fz = 60 * G * part - 15.0 + (8.0 if side == "l" else 0.0)
        data += [*rng.normal(0, 0.3, (2, share.size)), fz + rng.normal(0, 0.5, share.size),
                 *rng.normal(0, 20.0, (3, share.size))]  # fmt: skip
    flat = np.zeros(share.size)
    names += [f"{what}_{a}" for what in ("com", "com_acc", "l_foot", "r_foot") for a in "xyz"]
    still = rng.normal(0, 1e-4, (6, share.size))
    data += [flat + still[0], 0.2 * share - 0.1 + still[1], flat + 0.9 + still[2], *still[3:]]
    data += [flat, flat + 0.1, flat, flat, flat - 0.1, flat]
    return "\n".join([",".join(names), *rows(*data)])


def wrist(rng: Rng) -> str:
    """A tool in twelve attitudes, torques before forces, angles in degrees."""
    made = tool(np.random.default_rng(5))
    rpy = np.repeat(rng.uniform([-3.1, -1.4, -3.1], [3.1, 1.4, 3.1], (12, 3)), 25, axis=0)
    wrench = made.read(-rotations_of_rpy(rpy)[:, 2, :], rng)
    return "\n".join(
        rows(np.arange(300) / 100, *wrench[:, 3:].T, *wrench[:, :3].T, *np.degrees(rpy).T, sep=" ")
    )


def plate(rng: Rng) -> str:
    """Twenty-five points; the plate shows them 4 % too far out and 3 mm to one side."""
    x, y = (v.ravel() for v in np.meshgrid([-100, -50, 0, 50, 100], [-80, -40, 0, 40, 80]))
    lines = ["Punkt;x_soll;y_soll;COPx;COPy"]
    for i in range(75):
        a, b = float(x[i % 25]), float(y[i % 25])
        shown = 1.04 * a + 3 + rng.normal(0, 0.2), 1.04 * b + rng.normal(0, 0.2)
        lines.append(f"P{i % 25};{a};{b};{shown[0]:.3f};{shown[1]:.3f}".replace(".", ","))
    return "\n".join(lines)


def rmse(out: Path, quantity: str, split: str = "all") -> dict[str, float]:
    found = json.loads((out / "rmse.json").read_text())["rows"]
    return {
        r["stage"]: r["rmse"] for r in found if (r["quantity"], r["split"]) == (quantity, split)
    }


def kitchen_scale_is_true(out: Path) -> None:
    found = read_record(ParametersRecord, out / "parameters.json").parameters
    assert found["scale.scale"].value == pytest.approx(-3.4e-5, rel=1e-3)
    assert found["scale.bias"].value == pytest.approx(-12.0, abs=0.02)


def biped_is_true(out: Path) -> None:
    """The weight of stances left out: 3 % off before; what each cell has of it nobody can see."""
    found = rmse(out, "vgrf", "held_out")
    assert found["before"] == pytest.approx(5.3 * G * (1 - 1 / 1.03), rel=0.01)
    assert found["after"] < 0.01 * found["before"]


def weight_is_true(out: Path) -> None:
    """With both feet down only the sum of the offsets shows."""
    found = read_record(ParametersRecord, out / "parameters.json").parameters
    both = found["left.offset_fz"].value + found["right.offset_fz"].value
    assert both == pytest.approx(8.0, abs=0.2)
    forces = rmse(out, "fz")
    assert forces["after"] < 0.02 * forces["before"]


def tool_is_true(out: Path) -> None:
    made = tool(np.random.default_rng(5))
    found = read_record(ParametersRecord, out / "parameters.json").parameters
    offsets = [found[f"wrist.offset_{a}"].value for a in ("fx", "fy", "fz", "tx", "ty", "tz")]
    np.testing.assert_allclose(offsets[:3], made.offset[:3], atol=0.05)
    np.testing.assert_allclose(offsets[3:], made.offset[3:], atol=0.005)
    assert found["wrist.weight"].value == pytest.approx(made.weight_n, abs=0.05)


def plate_is_true(out: Path) -> None:
    found = rmse(out, "cop instrument", "held_out")
    assert found["after"] < 0.5e-3 < 4e-3 < found["none"]


def nothing_more(_out: Path) -> None:
    """A check makes no calibration."""


CASES: dict[str, tuple[Callable[[Rng], str], Callable[[Path], None]]] = {
    "kitchen_scale_hx711": (serial, kitchen_scale_is_true),
    "nao_like_biped": (biped, biped_is_true),
    "quadruped_foot_sensors": (quadruped, nothing_more),
    "humanoid_ankle_transducers": (humanoid, weight_is_true),
    "wrist_sensor_tool": (wrist, tool_is_true),
    "force_plate": (plate, plate_is_true),
}


@pytest.mark.parametrize("name", CASES)
def test_the_command_of_a_template_finds_the_truth(
    name: str, repository: Path, run: Run, tmp_path: Path
) -> None:
    recipe = repository / "recipes" / "templates" / f"{name}.toml"
    said = re.search(r"^# footcal (\S+) (\S+)(.*?) --recipe", recipe.read_text(), re.MULTILINE)
    assert said is not None
    write, is_true = CASES[name]
    log = tmp_path / said[2]
    log.write_text(write(np.random.default_rng(0)) + "\n", encoding="utf-8")
    out = tmp_path / "out"
    answer = run(said[1], log, *said[3].split(), "--recipe", recipe, "--out", out)
    assert answer.exit_code == 0, answer.err
    is_true(out)


def test_every_template_is_run(repository: Path) -> None:
    assert {p.stem for p in (repository / "recipes" / "templates").glob("*.toml")} == set(CASES)

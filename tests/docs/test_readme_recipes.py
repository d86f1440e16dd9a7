"""The recipes of the README run as printed, on simulated logs under the reader's own names.

So do the commands in the head of a recipe whose logs lie in `sample_data`.

Room: tests of the documents; nothing imports this.
"""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.effects.calibration import AXES
from tests.conftest import REPOSITORY
from tests.docs.test_documents import blocks, shell

README = REPOSITORY / "README.md"
LOGS = Path("logs")
SAVED_AS = {"my biped": "my_biped.toml", "my hexapod": "my_hexapod.toml", "my arm": "my_arm.toml"}
"""Robot -> the file that the README's commands call its recipe."""


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    LOGS.mkdir()
    return tmp_path


def save(robot: str) -> list[str]:
    """Save the recipe of a robot; give the README's commands that read it."""
    (text,) = [b.text for b in blocks(README) if b.language == "toml" and f'"{robot}"' in b.text]
    to = SAVED_AS[robot]
    Path(to).write_text(text, encoding="utf-8")
    return re.findall(rf"`(footcal [^`]*{to}[^`]*)`", README.read_text(encoding="utf-8"))


def simulate(experiment: str, recipe: str, more: str = "") -> Path:
    out = Path("sim") / experiment
    line = f"footcal simulate --recipe {recipe} --experiment {experiment} {more} --out {out}"
    assert shell(line) == 0
    return out


def assert_true(run: str, true: dict[str, float]) -> None:
    """Every parameter within five of its standard deviations of the truth."""
    found = json.loads((Path(run) / "parameters.json").read_text(encoding="utf-8"))["parameters"]
    off = {n: (found[n]["value"] - v) / found[n]["sd"] for n, v in true.items()}
    assert max(abs(v) for v in off.values()) < 5.0, off


def nao() -> str:
    return shlex.quote(str(REPOSITORY / "recipes" / "nao_simulated.toml"))


@pytest.mark.slow
def test_the_walking_robot(desk: Path) -> None:
    offline, online = save("my biped")
    weights = pd.read_parquet(simulate("weights", nao()) / "weights.parquet")
    weights["Masse"] = weights.pop("load_n") * 1e3 / 9.80665
    weights.rename(columns={"counts": "ADC"}).to_csv(LOGS / "weights_1.csv", index=False)
    walk = simulate("walk", nao(), "--duration-s 12")
    cells = pd.read_parquet(walk / "cells.parquet")
    own = {
        n: f"{n[0].upper()}Fsr{n.split('_')[1].upper()}" for n in map(str, cells) if "counts" in n
    }
    cells.rename(columns=own).to_csv(LOGS / "walk_cells.csv", index=False)
    body = pd.read_parquet(walk / "body.parquet")
    for axis in "xyz":
        body[f"CoM_{axis.upper()}"] = 1e3 * body.pop(f"com_{axis}_m")
    body.to_csv(LOGS / "walk_body.csv", index=False)
    assert shell(offline) == 0
    assert shell(online) == 0
    assert Path("out/walk/parameters.json").is_file()


def test_the_hanging_robot(desk: Path) -> None:
    (command,) = save("my hexapod")
    hung = pd.read_parquet(simulate("hang", "my_hexapod.toml") / "hang.parquet")
    hung.iloc[::10].to_csv(LOGS / "hang.csv", index=False)
    assert shell(command) == 0
    truth = json.loads(Path("sim/hang/truth.json").read_text(encoding="utf-8"))
    assert len(truth["robot"]["legs"]) == 6
    assert_true("out/hang", {n: v for n, v in truth["parameters"].items() if ".offset_" in n})


def test_the_wrist(desk: Path) -> None:
    """A tool of 9 N with its CoM 0.12 m along z, in 12 directions, noise of 0.02 N."""
    (command,) = save("my arm")
    rng = np.random.default_rng(11)
    turned = Rotation.from_quat(np.repeat(Rotation.random(12, random_state=4).as_quat(), 30, 0))
    offset = np.array([1.2, -0.7, 3.1, 0.05, -0.04, 0.02])
    force = turned.inv().apply([0.0, 0.0, -9.0])
    torque = np.cross([0.0, 0.0, 0.12], force)
    noise = rng.normal(0.0, 1.0, (360, 6)) * np.repeat([0.02, 0.001], 3)
    wrench = offset + np.hstack([force, torque]) + noise
    angles = turned.as_euler("ZYX", degrees=True)[:, ::-1] + rng.normal(0.0, 0.01, (360, 3))
    names = ["t", "Fx", "Fy", "Fz", "Tx", "Ty", "Tz", "roll", "pitch", "yaw"]
    table = np.column_stack([0.05 * np.arange(360), wrench, angles])
    pd.DataFrame(table, columns=names).to_csv(LOGS / "tool_1.csv", index=False)
    assert shell(command) == 0
    true = {"wrist.weight": 9.0, "wrist.com_z_mean": 0.12}
    true |= {f"wrist.offset_{a}": v for a, v in zip(AXES, offset, strict=True)}
    assert_true("out/tool", true)


@pytest.mark.slow
def test_commands_in_the_head_of_the_walk_recipe(desk: Path) -> None:
    for name in ("recipes", "sample_data"):
        (desk / name).symlink_to(REPOSITORY / name)
    head = (desk / "recipes" / "nao_walk.toml").read_text(encoding="utf-8").split("\nname")[0]
    lines = re.findall(r"^# (footcal .*(?:\n#  +.*)*)", head, re.MULTILINE)
    assert len(lines) == 3
    for line in lines:
        words = shlex.split(line.replace("\n#", " "))
        globbed = [sorted(map(str, Path().glob(w))) if "*" in w else [w] for w in words]
        assert shell(shlex.join(w for group in globbed for w in group)) == 0, line

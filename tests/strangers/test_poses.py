"""A hexapod of strangers from two logs and a sheet to the mounting of its transducers."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.conftest import Run
from tests.strangers.legged import _legs
from tests.strangers.rigs import G
from tests.strangers.thirty_first_robots import numbered_legs_and_hips

_TRUNK_KG = 9.0


@pytest.mark.slow
def test_hung_and_stood_logs_lead_to_the_mounting_by_what_init_says(
    run: Run, tmp_path: Path
) -> None:
    made = numbered_legs_and_hips(tmp_path, np.random.default_rng(0))
    recipe = tmp_path / "r.toml"
    assert run("init", *made.paths, "-o", recipe).exit_code == 0
    weights = [v for name, v in made.truth.values.items() if name.endswith(".weight")]
    mass = f"mass_kg = {_TRUNK_KG + sum(weights) / G:.4f}"
    recipe.write_text(re.sub(r"# mass_kg = .*", mass, recipe.read_text()))
    hung, stood = tmp_path / "hung", tmp_path / "stood"
    assert run("hang-calib", "--recipe", recipe, "--out", hung, "--quiet").exit_code == 0
    done = run("pose-calib", "--recipe", recipe, "--parameters", hung / "parameters.json",
               "--out", stood, "--quiet")  # fmt: skip
    assert done.exit_code == 0
    found = json.loads((stood / "parameters.json").read_text())["parameters"]
    nominal = tomllib.loads(recipe.read_text())["robot"]["legs"]
    names = tuple(nominal)
    for name, (_, frame) in _legs(np.random.default_rng(0), names).items():
        said = Rotation.from_euler("xyz", nominal[name]["rotation_rpy_rad"])
        turned = [found[f"{name}.mount_rot_{axis}"]["value"] for axis in "xyz"]
        sd = np.max([found[f"{name}.mount_rot_{axis}"]["sd"] for axis in "xyz"])
        truth = (said.inv() * frame).magnitude()
        assert np.linalg.norm(turned) == pytest.approx(truth, abs=max(5 * sd, 1e-3))

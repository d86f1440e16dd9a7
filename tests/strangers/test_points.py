"""A quadruped with one cell in each foot, from `init` to scales and zeros."""

from __future__ import annotations

from pathlib import Path

from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from tests.conftest import Run
from tests.foreign.owners import filled, logged
from tests.foreign.points import LEGS, points, quadruped_truth


def test_four_feet_of_one_cell_each(run: Run, tmp_path: Path) -> None:
    made, recipe = logged(points(7111, walking=False)), tmp_path / "r.toml"
    for name, frame in made.files.items():
        frame.to_csv(tmp_path / name, index=False)
    paths = [tmp_path / name for name in made.files]
    assert run("init", *paths, "-o", recipe).exit_code == 0
    fill = {table: keys for table, keys in made.fill.items() if ".feet." not in table}
    text = filled(recipe.read_text(encoding="utf-8"), fill)
    recipe.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    done = run("static-init", "--recipe", recipe, "--no-pictures", "--out", out)
    assert done.exit_code == 0, done.err
    found = read_record(ParametersRecord, out / "parameters.json").parameters
    robot = quadruped_truth(7111)
    for leg, scale in zip(LEGS, robot["scale"], strict=True):
        one = found[f"{leg}_foot.scale"]
        assert one.sd is not None
        assert abs(one.value - scale) < 4.0 * one.sd
        assert 0.01 * scale < one.sd < 0.015 * scale  # the stated mass, little more
    # channels that are the cells of no foot end with one line, not with a crash
    recipe.write_text(text.replace("[robot.feet.hl.", "[robot.feet.hind."), encoding="utf-8")
    wrong = run("static-init", "--recipe", recipe, "--out", tmp_path / "wrong")
    assert wrong.exit_code == 2
    assert "do not fit" in wrong.err

"""Recipes refuse what they do not know; records cannot be misread."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from footcal_cli.core.bench.plateaus import PlateauOptions
from footcal_cli.core.hang.joint import HangOptions
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.noise import WalkNoise
from footcal_cli.core.online.streams import MergeRule
from footcal_cli.core.parameters import Estimates, Status
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.steady import SteadyRule
from footcal_cli.core.quiet import QuietRule
from footcal_cli.core.study.window import WindowRule
from footcal_cli.errors import UsageError
from footcal_cli.recipe import read_recipe
from footcal_cli.recipe.options import (
    ApplyOptions,
    HangCalibOptions,
    NoiseOptions,
    OfflineFitOptions,
    OnlineReplayOptions,
    PlateauSettings,
    PoseCalibOptions,
    StaticInitOptions,
)
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import ParametersRecord, covariance_blocks, parameter_records
from footcal_cli.records.schemas import SCHEMAS

COMMANDS = {"offline_fit", "check"}


def recipe_line(folder: Path, text: str) -> str:
    path = folder / "r.toml"
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        read_recipe(path, COMMANDS)
    assert caught.value.exit_code == 2
    return caught.value.line()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[robt]\nname='x'", ("robt", "did you mean 'robot'")),
        ("[robot]\nmas_kg=5", ("robot.mas_kg", "did you mean 'mass_kg'")),
        ("[robot.feet.left.cels]", ("cels", "did you mean 'cells'")),
        ("[robot.feet.left.cells.fl]\nx_m=1\nym=2", ("robot.feet.left.cells.fl",)),
        ("[columns]\nload_n={colum='a'}", ("columns.load_n",)),
        ("[robot]\nmass_kg=-1", ("robot.mass_kg", "-1")),
        ("[robot]\nmass_kg='five'", ("robot.mass_kg", "five")),
        ("[robot]\nchannels=['a','b','a']", ("channel 'a' is named twice",)),
        ("[robot\n", ("TOML",)),
    ],
)
def test_a_faulty_recipe_is_one_line(tmp_path: Path, text: str, words: tuple[str, ...]) -> None:
    line = recipe_line(tmp_path, text)
    for word in words:
        assert word in line, line


def test_every_recipe_of_the_project_is_valid(repository: Path) -> None:
    from footcal_cli.commands import option_tables

    paths = sorted((repository / "recipes").glob("*.toml"))
    assert paths
    for path in paths:
        read_recipe(path, option_tables())


def test_data_paths_are_relative_to_the_recipe_and_patterns_must_match(tmp_path: Path) -> None:
    (tmp_path / "a1.csv").touch()
    (tmp_path / "a2.csv").touch()
    path = tmp_path / "r.toml"
    path.write_text("[data]\nweights='a*.csv'\nbody='b*.csv'\n")
    recipe = read_recipe(path, COMMANDS)
    assert [p.name for p in recipe.data_paths("weights")] == ["a1.csv", "a2.csv"]
    assert recipe.data_paths("hang") == []
    with pytest.raises(UsageError, match="matches no file"):
        recipe.data_paths("body")


def calibration() -> ParametersRecord:
    estimates = Estimates(
        ("a.scale", "a.bias", "b.scale"),
        ("N/count", "N", "N/count"),
        np.array([-2e-5, 190.0, 3e-5]),
        np.array([[4e-14, 1e-8, 0.0], [1e-8, 0.04, 0.0], [0.0, 0.0, 0.0]]),
        (Status.ESTIMATED, Status.ESTIMATED, Status.FIXED),
    )
    return ParametersRecord(
        command="offline-fit",
        created="2026-01-01T00:00:00+00:00",
        robot="r",
        gravity_mps2=9.80665,
        sign_convention="s",
        frame="f",
        expressed_at="e",
        parameters=parameter_records(estimates),
        covariance=covariance_blocks(estimates),
    )


def test_a_calibration_reads_back_as_it_was_written(tmp_path: Path) -> None:
    record = calibration()
    write_record(record, tmp_path / "parameters.json")
    again = read_record(ParametersRecord, tmp_path / "parameters.json")
    assert again == record
    np.testing.assert_allclose(
        again.covariance_of(("a.bias", "a.scale")), [[0.04, 1e-8], [1e-8, 4e-14]]
    )
    assert again.parameters["b.scale"].sd is None
    with pytest.raises(UsageError, match=r"did you mean 'a\.scale'"):
        again.value("a.scal")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "footcal.rmse"}, "schema is 'footcal.rmse'"),
        ({"schema_version": 2}, "newer than this footcal"),
        ({"paramters": {}}, "paramters"),
        ({"gravity_mps2": "nine"}, "gravity_mps2"),
    ],
)
def test_another_newer_or_edited_file_is_refused(
    tmp_path: Path, change: dict[str, object], words: str
) -> None:
    content = json.loads(calibration().model_dump_json(by_alias=True)) | change
    path = tmp_path / "parameters.json"
    path.write_text(json.dumps(content))
    with pytest.raises(UsageError, match=words):
        read_record(ParametersRecord, path)


def test_json_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "parameters.json"
    path.write_text('{"schema": ')
    with pytest.raises(UsageError, match="not valid JSON"):
        read_record(ParametersRecord, path)


def test_every_record_has_a_schema_that_requires_its_name() -> None:
    for model in SCHEMAS.values():
        schema = model.model_json_schema(by_alias=True)
        assert schema["properties"]["schema"]["const"].startswith("footcal.")
        assert schema["additionalProperties"] is False


WRITTEN_TWICE: list[tuple[type[BaseModel], type, dict[str, str]]] = [
    (PlateauSettings, PlateauOptions, {}),
    (HangCalibOptions, HangOptions, {}),
    (PoseCalibOptions, PoseOptions, {}),
    (PoseCalibOptions, SteadyRule, {
        "rate_nps": "steady_rate_nps", "duration_s": "steady_duration_s",
        "window_s": "steady_window_s",
    }),
    (StaticInitOptions, QuietRule, {
        "acceleration_mps2": "largest_acceleration_mps2", "rate_radps": "largest_rate_radps",
    }),
    (OnlineReplayOptions, MergeRule, {"largest_acc_mps2": "largest_acceleration_mps2"}),
    (OnlineReplayOptions, WindowRule, {}),
    (OnlineReplayOptions, MemoryOptions, {"plate": "hanging_plate", "swing": "swing_rows"}),
]  # fmt: skip
DECIDED_ELSEWHERE = {
    "tilt",
    "noise",
    "structure",
    "translation_sd_m",
    "com_sd_m",
    "rotation_sd_rad",
}
"""A recipe lets the log, the evidence or a usual robot decide where a caller of the core says."""


@pytest.mark.parametrize(("recipe", "core", "renamed"), WRITTEN_TWICE)
def test_a_recipe_and_the_core_agree_on_defaults(
    recipe: type[BaseModel], core: type, renamed: dict[str, str]
) -> None:
    asked = {name: field.default for name, field in recipe.model_fields.items()}
    own = {renamed.get(f.name, f.name): f.default for f in fields(core)}
    both = (asked.keys() & own.keys()) - DECIDED_ELSEWHERE
    assert both >= set(renamed.values())
    assert len(both) > 1
    assert {name: asked[name] for name in both} == {name: own[name] for name in both}


@pytest.mark.parametrize(
    ("robot", "smallest_n"),
    [("", 5.0), ("mass_kg = 5.3", 5.0), ("mass_kg = 0.5", 0.5 * 0.980665),
     ("mass_kg = 5.3\nmin_force_n = 8.0", 8.0)],
)  # fmt: skip
def test_the_robot_has_one_smallest_force_for_every_cop(
    tmp_path: Path, robot: str, smallest_n: float
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(f"[robot]\n{robot}\n[apply]\nmin_force_n = 2.0\n", encoding="utf-8")
    recipe = read_recipe(path, ("apply",))
    for model in (OfflineFitOptions, OnlineReplayOptions, StaticInitOptions):
        found = recipe.options_for(model, model.__name__).model_dump()
        assert found["min_force_n"] == pytest.approx(smallest_n)
    assert recipe.options_for(ApplyOptions, "apply").min_force_n == 2.0
    old = recipe.options_for(ApplyOptions, "none", {"least_force_n": 3.0})
    assert old.min_force_n == 3.0


def test_a_recipe_may_give_every_noise_of_a_walk() -> None:
    assert set(NoiseOptions.model_fields) == {field.name for field in fields(WalkNoise)}

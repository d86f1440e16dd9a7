"""What every command promises, looped over the app: a new command is tested by being listed."""

from __future__ import annotations

import inspect
import json
from importlib import import_module
from pathlib import Path

import pytest
import typer

from footcal_cli.app import COMMANDS, function_of
from footcal_cli.commands import option_tables
from footcal_cli.core.effects import TABLE
from footcal_cli.recipe import CommandOptions
from tests.conftest import Run

FUNCTIONS = {name: function_of(name) for name in COMMANDS}
RUNS = sorted(name for name, f in FUNCTIONS.items() if "out" in inspect.signature(f).parameters)
"""Commands that leave a run folder."""


def module_of(name: str) -> str:
    return name.replace("-", "_")


def test_one_spelling_for_command_module_and_function() -> None:
    for name, function in FUNCTIONS.items():
        assert function.__module__ == f"footcal_cli.commands.{module_of(name)}"
        assert function.__name__ == module_of(name)


def test_every_module_of_the_room_is_a_command() -> None:
    assert {module_of(name) for name in COMMANDS} == option_tables()


def test_nothing_is_lost_that_was_offered() -> None:
    """Commands, options and effects of commit 6403e2b, from which on the house was rebuilt."""
    offered = json.loads((Path(__file__).parent / "offered_at_6403e2b.json").read_text("utf-8"))
    for name, options in offered["commands"].items():
        alone = typer.Typer()
        alone.command()(FUNCTIONS[name])
        now = {
            word
            for parameter in typer.main.get_command(alone).params
            for word in (*parameter.opts, *parameter.secondary_opts)
        }
        assert not set(options) - now, name
    assert not set(offered["effects"]) - TABLE.keys()


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_help_says_in_one_sentence_what_it_does(run: Run, name: str) -> None:
    answer = run(name, "--help")
    assert answer.exit_code == 0
    first = (FUNCTIONS[name].__doc__ or "").strip().splitlines()[0]
    assert first == COMMANDS[name]
    assert first.endswith(".")
    assert len(first) <= 100


@pytest.mark.parametrize("name", RUNS)
def test_options_are_a_frozen_model_of_their_own(name: str) -> None:
    module = import_module(f"footcal_cli.commands.{module_of(name)}")
    expected = "".join(word.capitalize() for word in name.split("-")) + "Options"
    model = getattr(module, expected)
    assert issubclass(model, CommandOptions)
    assert model.__doc__


@pytest.mark.parametrize("name", [name for name in RUNS if name not in ("convert", "export")])
def test_figures_can_be_left_out(name: str) -> None:
    assert "no_pictures" in inspect.signature(FUNCTIONS[name]).parameters


@pytest.mark.parametrize("name", RUNS)
def test_a_misspelt_option_in_a_recipe_is_named(run: Run, name: str, tmp_path: Path) -> None:
    recipe = tmp_path / "r.toml"
    recipe.write_text(f"[{module_of(name)}]\nno_such_option_zz = 1\n")
    answer = run(name, "--recipe", recipe, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert "no_such_option_zz" in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", RUNS)
def test_a_folder_in_use_is_refused(run: Run, name: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    answer = run(name, "--out", out)
    assert answer.exit_code == 2
    assert answer.err.count("\n") == 1
    assert (out / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("name", RUNS)
def test_without_a_log_it_says_what_is_missing(run: Run, name: str, tmp_path: Path) -> None:
    answer = run(name, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert answer.err.startswith("footcal: error: ")
    assert "Remedy:" in answer.err
    assert not (tmp_path / "out").exists()

"""Help: every command in a group, with an example that names it."""

from __future__ import annotations

import typer

from footcal_cli.app import COMMANDS, function_of
from footcal_cli.commands.helptexts import GROUP_OF, JSON_ANSWERS, epilog_of


def test_every_command_has_a_group_and_every_group_only_commands() -> None:
    assert set(GROUP_OF) == set(COMMANDS)


def test_examples_are_of_their_command() -> None:
    for name in COMMANDS:
        assert f"Example: footcal {name}" in epilog_of(name)


def test_usage_names_what_may_repeat_once() -> None:
    for name in COMMANDS:
        one = typer.Typer(add_completion=False)
        one.command(name)(function_of(name))
        command = typer.main.get_command(one)
        usage = command.get_usage(command.make_context(name, [], resilient_parsing=True))
        assert "[[" not in usage
        assert usage.count("...") <= 1


def test_every_help_names_the_columns_it_reads_and_its_json() -> None:
    reads_no_log = {"export", "effects", "schema"}
    for name in COMMANDS:
        assert ("Columns: " in epilog_of(name)) is (name not in reads_no_log), name
        assert ("--json prints one JSON" in epilog_of(name)) is (name in JSON_ANSWERS), name
        assert "--json" in epilog_of(name)

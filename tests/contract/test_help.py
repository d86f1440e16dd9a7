"""Help: every command in a group, with an example that names it."""

from __future__ import annotations

from footcal_cli.app import COMMANDS
from footcal_cli.commands.helptexts import GROUP_OF, epilog_of


def test_every_command_has_a_group_and_every_group_only_commands() -> None:
    assert set(GROUP_OF) == set(COMMANDS)


def test_examples_are_of_their_command() -> None:
    for name in COMMANDS:
        assert f"Example: footcal {name}" in epilog_of(name)

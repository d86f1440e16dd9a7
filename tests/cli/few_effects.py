"""Diagnoses of a few effects take half as long as those of the whole table, which are slow."""

from __future__ import annotations

import pytest

from footcal_cli.core.effects import TABLE


def without_all_but(*effects: str) -> tuple[str, ...]:
    """The words that leave all other effects out of the table."""
    return tuple(word for name in TABLE if name not in effects for word in ("--without", name))


def few_or_all(*effects: str) -> pytest.MarkDecorator:
    """The test is given `few`: words for these effects, and, where slow, for the whole table."""
    return pytest.mark.parametrize(
        "few",
        [without_all_but(*effects), pytest.param((), marks=pytest.mark.slow)],
        ids=["few effects", "all effects"],
    )

"""Sample logs as `check` reads them, with a fault put in, and the warnings it then gives."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pandas as pd

from footcal_cli.commands import option_tables
from footcal_cli.recipe import Recipe, Robot, read_recipe
from footcal_cli.session.inspection import inspect
from footcal_cli.tables.columns import TableType
from footcal_cli.tables.table import Table, read_table
from tests.conftest import REPOSITORY

SAMPLES = REPOSITORY / "sample_data"
Frame = pd.DataFrame
G = 9.80665


@cache
def recipe(name: str) -> Recipe:
    return read_recipe(REPOSITORY / "recipes" / f"{name}.toml", option_tables())


@cache
def clean(path: Path, kind: TableType, name: str) -> Table:
    foreign = recipe(name).reading(path)
    return read_table(path, kind, foreign, gravity_mps2=G)


def bent(table: Table, change: Callable[[Frame], Frame]) -> Table:
    return Table(change(table.data.copy()), table.path, "")


def alarms(table: Table, kind: TableType, robot: Robot) -> set[str]:
    return {f.code for f in inspect(table, kind, robot) if f.severity != "note"}


def times(pattern: str, factor: float) -> Callable[[Frame], Frame]:
    def change(log: Frame) -> Frame:
        names = [c for c in log.columns if pattern in c]
        assert names
        return log.assign(**{c: factor * log[c] for c in names})

    return change

"""Effects by name wherever they come from: the table, a recipe, a calibration, other packages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np

from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, Scope
from footcal_cli.core.effects.formula import FormulaError
from footcal_cli.core.effects.own import FormulaShape, OwnRow, own_effect
from footcal_cli.errors import UsageError, nearest
from footcal_cli.records.own_effects import OwnEffect
from footcal_cli.records.results import EffectRecord

GROUP = "footcal.effects"
"""Entry points that give an `Effect` or several."""
_FREE = 1e3  # usual sizes that a size without bounds may have
_SCOPES = {
    "cell": Scope.CHANNEL, "foot": Scope.FOOT, "leg": Scope.LEG, "robot": Scope.ROBOT,
}  # fmt: skip


def effect_of(item: EffectRecord) -> Effect:
    """The effect that a calibration contains.

    Raises
    ------
    UsageError
        Neither the table, the calibration nor an installed package says what it is.
    """
    if item.row is not None:
        return effect_of_row(item.row)
    found = TABLE.get(item.effect) or installed_effects().get(item.effect)
    if found is None:
        raise UsageError(
            f"the calibration contains '{item.effect}', which nothing here knows",
            remedy=f"install the package that gives it (entry points {GROUP})",
        )
    return found


def table_with(rows: Iterable[OwnEffect], file: Path | None = None) -> dict[str, Effect]:
    """The table of effects, those of installed packages and those of a recipe.

    Raises
    ------
    UsageError
        A row of the recipe is none, or has the name of another effect.
    """
    table = {**TABLE, **installed_effects()}
    for row in rows:
        if row.name in table:
            raise UsageError(
                f"[[effect]] name = '{row.name}': there is such an effect already", file=file,
                remedy="give it another name",
            )  # fmt: skip
        table[row.name] = effect_of_row(row, file)
    return table


def effect_of_row(row: OwnEffect, file: Path | None = None) -> Effect:
    """The effect of a row of a recipe."""
    low, high = row.bounds or (-_FREE * row.usual, _FREE * row.usual)
    if not low <= 0.0 <= high or not low < high:
        raise UsageError(
            f"[[effect]] {row.name}: bounds must hold 0, where the effect is absent", file=file,
            value=str([low, high]), remedy="widen them",
        )  # fmt: skip
    shapes = tuple(
        FormulaShape(name, shape.unit, tuple(sorted(shape.values)))
        for name, shape in row.shapes.items()
    )
    if not all(np.isfinite(v) and v > 0 for shape in shapes for v in shape.values):
        raise UsageError(
            f"[[effect]] {row.name}: values of a shape must be positive", file=file,
            remedy="write the formula with their signs",
        )  # fmt: skip
    try:
        return own_effect(
            OwnRow(
                row.name, row.adds, row.remedy, row.unit, row.usual, row.size, (low, high),
                _SCOPES[row.per], row.experiments, shapes, row.source,
            )
        )  # fmt: skip
    except FormulaError as error:
        raise UsageError(
            f"[[effect]] {row.name}: {error}", file=file,
            remedy="footcal effects --signals lists what a formula may use",
        ) from None  # fmt: skip


def installed_effects() -> Mapping[str, Effect]:
    """Effects of installed packages (entry points `GROUP`).

    Raises
    ------
    UsageError
        An entry point gives something else, or the name of a known effect.
    """
    found: dict[str, Effect] = {}
    for point in entry_points(group=GROUP):
        given = point.load()
        for effect in (given,) if isinstance(given, Effect) else tuple(given):
            if not isinstance(effect, Effect) or effect.name in TABLE:
                name = getattr(effect, "name", type(effect).__name__)
                raise UsageError(
                    f"entry point {point.value} of {GROUP} gives '{name}', which is no new effect",
                    remedy="correct that package, or uninstall it",
                )
            found[effect.name] = effect
    return found


def known_effect(name: str, table: Mapping[str, Effect], asked_as: str = "") -> Effect:
    """An effect by name.

    Raises
    ------
    UsageError
        No such effect; names the nearest.
    """
    if name not in table:
        lead = f"{asked_as}: " if asked_as else ""
        raise UsageError(
            f"{lead}no effect named '{name}'{nearest(name, list(table))}",
            remedy="footcal effects lists them",
        )
    return table[name]


def record_of_effect(
    effect: Effect, owners: Mapping[str, tuple[str, ...]], rows: Iterable[OwnEffect]
) -> EffectRecord:
    """An effect as a calibration keeps it, with its row if it is a recipe's."""
    row = next((row for row in rows if row.name == effect.name), None)
    return EffectRecord(effect=effect.name, owners=dict(owners), row=row)

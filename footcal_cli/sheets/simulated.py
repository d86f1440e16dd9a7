"""What a simulation says of itself: its files and its effects."""

from __future__ import annotations

from collections.abc import Sequence

from footcal_cli.core.effects.contract import Scope
from footcal_cli.core.simulation.scenario import EffectRequest, Scenario
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Sheet, number


def verdict(kind: str, scenario: Scenario, requests: Sequence[EffectRequest]) -> VerdictRecord:
    """What was simulated, in one sentence."""
    rows = {stem: len(next(iter(columns.values()))) for stem, columns in scenario.files.items()}
    carried = (
        "with " + ", ".join(f"{r.effect.name} ({_who(r)})" for r in requests)
        if requests
        else "with calibration, mounting and noise only"
    )
    main = next(iter(rows))
    return VerdictRecord(
        level="good", sentence=f"Simulated {kind}: {rows[main]} rows of {main} {carried}."
    )


def _who(request: EffectRequest) -> str:
    """Who carries an effect, in words."""
    if request.owner is not None:
        return request.owner
    return "robot" if request.effect.scope is Scope.ROBOT else f"every {request.effect.scope.value}"


def file_sheet(scenario: Scenario) -> Sheet:
    """The files of a simulation with their columns."""
    return Sheet(
        "Files",
        ("file", "rows", "columns"),
        [
            (f"{stem}.parquet", str(len(next(iter(columns.values())))), _named(tuple(columns)))
            for stem, columns in scenario.files.items()
        ],
    )


def _named(columns: tuple[str, ...]) -> str:
    """The first columns by name, and how many there are."""
    return f"{', '.join(columns[:3])} … ({len(columns)})"


def effect_sheet(requests: Sequence[EffectRequest]) -> Sheet:
    """The effects that were asked for, with all their values."""
    return Sheet(
        "Effects asked for",
        ("effect", "carried by", "parameter", "value", "unit", "what it does"),
        [
            (r.effect.name, _who(r), p.name, number(r.values.get(p.name, p.neutral)), p.unit,
             r.effect.formula)
            for r in requests
            for p in r.effect.parameters
        ],
    )  # fmt: skip

"""What a simulation says of itself: its files and its effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects.contract import Scope, Stage
from footcal_cli.core.log import Log
from footcal_cli.core.simulation.scenario import EffectRequest, Scenario
from footcal_cli.plots.simulated import plot_shown_and_true
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import Picture, Sheet, number
from footcal_cli.report.outcome import Outcome


def outcome_of(
    robot: str, kind: str, scenario: Scenario, requests: Sequence[EffectRequest]
) -> Outcome:
    """The logs of a simulated experiment."""
    return Outcome(
        title=f"Simulated {kind} of {robot}",
        verdict=verdict(kind, scenario, requests),
        pictures=pictures_of(scenario),
        sheets=(file_sheet(scenario), effect_sheet(requests)),
        footer=(
            "The logs hold what the sensors showed; truth.json holds every parameter they were "
            "distorted with. The same recipe, effects and seed give the same bytes.",
        ),
        tables={f"{stem}.parquet": columns for stem, columns in scenario.files.items()},
    )


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
        level="good",
        sentence=f"Simulated {kind}: {rows[main]:,} rows in {main}.parquet, {carried}.",
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
            (f"{stem}.parquet", f"{len(next(iter(columns.values()))):,}", _named(tuple(columns)))
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


def _believed(scenario: Scenario) -> Log:
    """What the sensors showed, converted with their true calibration."""
    links = scenario.chain.links
    calibration = Chain(tuple(item for item in links if item.effect.stage is Stage.CALIBRATION))
    return calibration.remove(scenario.shown, scenario.values)[0]


def _largest_difference(scenario: Scenario) -> str:
    """The channel that is furthest from the truth, in one sentence."""
    shown, truth = _believed(scenario), scenario.truth
    error = np.nanmax(np.abs(shown.readings - truth.readings), axis=0)
    worst = int(np.argmax(error))
    channel = shown.channels[worst]
    unit = "Nm" if channel.rpartition(".")[2].startswith("t") else "N"
    return f"Largest difference: {number(float(error[worst]), 2)} {unit} ({channel})."


def pictures_of(scenario: Scenario) -> tuple[Picture, ...]:
    """What was shown and what was true."""
    return (
        Picture(
            "shown_and_true",
            lambda: plot_shown_and_true(_believed(scenario), scenario.truth),
            "What the sensors showed, converted with their true calibration (colour), over what "
            "was true (thin line); below, the difference: effects and noise.",
            title="Measured and true loads, and their difference",
            result=lambda: _largest_difference(scenario),
            zoom=True,
        ),
    )

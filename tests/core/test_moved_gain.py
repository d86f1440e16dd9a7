"""A cell whose gain is no longer what weights have determined shows in no residual of a walk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footcal_cli.core.diagnosis.bridge import problem_from
from footcal_cli.core.diagnosis.inquiry import Inquiry
from footcal_cli.core.diagnosis.investigation import investigate
from footcal_cli.core.diagnosis.moved_gain import gains_against, with_moved_gain
from footcal_cli.core.diagnosis.next_experiment import ambiguity, next_menu
from footcal_cli.core.diagnosis.signals import describe
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.inference.case import Case, rows_of
from footcal_cli.core.inference.tracking import gain_and_bias
from footcal_cli.sheets.diagnosis.experiment import next_experiment
from tests.core.test_diagnosis_bridge import ROBOT, Hidden, walk_case

MOUNTING = 0.01
LEFT = tuple(c for c in ROBOT.channels if c.startswith("left"))


def walked(
    seed: int, gains: dict[str, float], hidden: Hidden | None = None, duration_s: float = 60.0
) -> Case:
    """A walk of calibrated cells, some of which read so many times what they did."""
    case = walk_case(seed, hidden, duration_s=duration_s)
    (log,) = case.logs
    scale = np.array([case.values[f"{c}.scale"] for c in ROBOT.channels])
    zero = np.array([case.values[f"{c}.bias"] for c in ROBOT.channels])
    rng = np.random.default_rng([seed, 5])
    mounted = {c: 1.0 + 0.5 * MOUNTING * rng.standard_normal() for c in ROBOT.channels}
    factor = np.array([gains.get(c, 1.0) * mounted[c] for c in ROBOT.channels])
    force = (log.readings * scale + zero) * factor
    ways = gain_and_bias(ROBOT.channels, case.values, MOUNTING)
    return replace(case, logs=(replace(log, readings=(force - zero) / scale),), directions=ways)


def moved(case: Case) -> tuple[str, ...]:
    gains = gains_against(case, problem_from(case, rows_of(case), [], describe))
    return tuple(gain.cell for gain in gains if gain.certain)


@pytest.mark.parametrize("seed", range(4))
def test_gains_that_a_mounting_moves_have_not_moved(seed: int) -> None:
    assert moved(walked(seed, {})) == ()


@pytest.mark.parametrize(("seed", "by"), [(1, 1.08), (2, 0.92)])
def test_one_cell_that_reads_too_much_or_too_little_is_found(seed: int, by: float) -> None:
    cell = ROBOT.channels[seed]
    assert moved(walked(seed, {cell: by})) == (cell,)


def test_all_cells_of_a_foot_are_found_together() -> None:
    assert moved(walked(3, dict.fromkeys(LEFT, 0.95))) == LEFT


def test_gains_that_stand_in_for_something_else_are_none() -> None:
    """A CoM that is off asks for more in front and less behind, in both feet."""
    offset: Hidden = ("com_offset", {"robot": ("robot",)}, {"robot.com_offset_x": 0.015})
    assert moved(walked(1, {}, offset)) == ()


def test_the_answer_names_the_cell_and_its_size() -> None:
    cell = ROBOT.channels[2]
    case, table = walked(2, {cell: 1.1}), {n: e for n, e in TABLE.items() if n != "scale_change"}
    before = investigate(case, {}, describe)
    gains = {n: e for n, e in TABLE.items() if Trait.GAIN in e.traits}
    found = with_moved_gain(before, gains, Inquiry({**table, **gains}, describe))
    assert found.verdict == "ambiguous"
    (item,) = found.found
    assert item.owner == cell
    alike = {"creep", "temperature_scale", "nonlinearity"}
    assert {r.effect for r in item.cause.rivals} == alike
    assert item.cause.size.value == pytest.approx(0.1, abs=2.5 * MOUNTING)
    (gain,) = (g for g in found.gains_moved if g.certain)
    assert gain.cell == cell
    assert gain.change.low < 0.1 < gain.change.high
    assert all(abs(g.change.value) < 3.0 * MOUNTING for g in found.gains_moved if not g.certain)
    contenders = ambiguity(found, TABLE)
    assert {c.signature.effect for c in contenders} == {"scale_change", *alike}
    assert all(TABLE[c.signature.effect].size.name in c.values for c in contenders)
    # a rehearsed walk would let its gain follow: what the table says is what to do next
    assert next_menu(found, TABLE) is None
    proposed = next_experiment(found, TABLE, None)
    assert proposed is not None
    assert proposed.words == TABLE["scale_change"].separates


def test_a_crosstalk_is_no_gain_of_the_neighbour() -> None:
    """What a cell has from its neighbour alone is nearly a gain of that neighbour."""
    cell = ROBOT.channels[0]
    shown = {f"{cell}.crosstalk": 0.12, f"{cell}.crosstalk_from": 1.0}
    case = walked(1, {}, ("crosstalk", {cell: (cell,)}, shown), duration_s=30.0)
    before = investigate(case, {}, describe)

    def named(*kinds: Trait) -> set[str]:
        asked = {n: e for n, e in TABLE.items() if set(kinds) & set(e.traits)}
        found = with_moved_gain(before, asked, Inquiry(TABLE, describe)).found
        return {s.effect for f in found for s in (f.cause.signature, *f.cause.rivals)}

    assert "scale_change" in named(Trait.GAIN)
    both = named(Trait.GAIN, Trait.MIXTURE)
    assert not both or "crosstalk" in both

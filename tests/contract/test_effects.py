"""Every effect of the table keeps its promises: neutral, inverse, chunks, fields."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.chain import link
from footcal_cli.core.effects import TABLE, UnknownEffectError, find_effect
from footcal_cli.core.effects.contract import Effect, GridOf, Stage, Trait, units_of
from footcal_cli.core.effects.memory import linear_recurrence, play
from footcal_cli.core.effects.transport import REMEMBERED_ROWS
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.log import Log
from tests.contract.logs import CELLS, cell_log, difference, log_for, typical

EXPERIMENTS = {"weights", "placements", "stand", "walk", "hang", "pose"}
NAMES_OF_DESIGN = set(
    """
nonlinearity hysteresis creep crosstalk temperature_bias temperature_scale bias_drift bias_jump
saturation quantisation channel_stuck channel_swap channel_duplicate sign_flip
cell_position load_bypass hanging_plate slip delay lag clock_drift dropped_samples
imu_tilt accel_bias mass com_offset angular_momentum wrong_weight wrong_hole wrong_unit
offset_drift offset_change scale_matrix cross_coupling mount_rotation mount_translation axis_flip
leg_weight leg_com cable_drag case_strain hang_tilt robot_weight body_tilt
""".split()  # noqa: SIM905  (as the design lists them)
)

every_invertible_effect = pytest.mark.parametrize(
    "effect", [e for e in TABLE.values() if e.invertible], ids=lambda effect: effect.name
)
every_effect = pytest.mark.parametrize("effect", TABLE.values(), ids=TABLE.keys())


def neutral(effect: Effect, units: int) -> dict[str, np.ndarray]:
    return {p.name: np.full(units, p.neutral) for p in effect.parameters}


def units(effect: Effect, log: Log) -> int:
    return len(units_of(effect.scope, log.channels))


def test_every_name_of_the_design_is_in_the_table() -> None:
    assert set(TABLE) >= NAMES_OF_DESIGN


def test_the_table_runs_from_bench_to_transport() -> None:
    stages = [effect.stage for effect in TABLE.values()]
    assert stages == sorted(stages)
    assert set(stages) == set(Stage)


def test_parameter_names_are_unique_among_effects_of_one_scope() -> None:
    names = [(e.scope, p.name) for e in TABLE.values() for p in e.parameters]
    assert len(set(names)) == len(names)


@every_effect
def test_every_field_is_filled_and_consistent(effect: Effect) -> None:
    for text in (effect.formula, effect.source, effect.remedy, effect.separates):
        assert text.strip()
        assert "\n" not in text
    assert effect.experiments
    assert set(effect.experiments) <= EXPERIMENTS
    assert effect.mimics
    assert set(effect.mimics) <= set(TABLE) - {effect.name}
    assert effect.sizes[0] is effect.parameters[0]
    for p in effect.parameters:
        assert p.lower <= p.neutral <= p.upper
        assert p.unit
        assert p.prior_sd > 0
        assert bool(p.grid) == p.shape
        shares = p.grid_of is GridOf.LOAD
        bounds = (0.0, 1.0) if shares else (p.lower, p.upper)
        assert all(bounds[0] <= value <= bounds[1] for value in p.grid)


@every_effect
def test_neutral_parameters_change_nothing(effect: Effect) -> None:
    log = log_for(effect)
    theta = neutral(effect, units(effect, log))
    assert not link(effect, log.channels).acts({})
    for transform in (effect.apply, effect.remove):
        assert difference(log, transform(log, theta, None)[0]) < 1e-12


@every_effect
def test_typical_sizes_change_something(effect: Effect) -> None:
    log = log_for(effect)
    theta = typical(effect, units(effect, log))
    assert difference(log, effect.apply(log, theta, None)[0]) > 1e-6


@every_invertible_effect
@pytest.mark.parametrize("seed", range(3))
def test_remove_undoes_apply(effect: Effect, seed: int) -> None:
    log = log_for(effect)
    theta = typical(effect, units(effect, log), seed)
    distorted, _ = effect.apply(log, theta, None)
    restored, _ = effect.remove(distorted, theta, None)
    assert difference(log, restored) <= effect.tolerance


@pytest.mark.parametrize("share", [0.0, 0.3, -0.4, 0.8])
@pytest.mark.parametrize(
    "effect", [e for e in TABLE.values() if e.other_form], ids=lambda e: e.name
)
def test_another_form_is_undone_too(effect: Effect, share: float) -> None:
    assert effect.other_form is not None
    apply, remove = effect.other_form
    log = log_for(effect)
    usual = typical(effect, units(effect, log))
    theta = {**usual, effect.size.name: np.full_like(usual[effect.size.name], share)}
    distorted, _ = apply(log, theta, None)
    assert (difference(log, distorted) > 1e-6) == bool(share)
    restored, _ = remove(distorted, theta, None)
    assert difference(log, restored) <= effect.tolerance


@every_effect
def test_remove_of_what_has_no_inverse_is_no_worse_than_leaving_it(effect: Effect) -> None:
    log = log_for(effect)
    theta = typical(effect, units(effect, log))
    distorted, _ = effect.apply(log, theta, None)
    restored, _ = effect.remove(distorted, theta, None)
    assert difference(log, restored) <= difference(log, distorted) * (1 + 1e-12)


@every_effect
@pytest.mark.parametrize("direction", ["apply", "remove"])
def test_chunk_by_chunk_equals_whole(effect: Effect, direction: str) -> None:
    log = log_for(effect)
    theta = typical(effect, units(effect, log))
    transform = getattr(effect, direction)
    whole, _ = transform(log, theta, None)
    state = None
    parts = []
    seams = [0, 1, 100, 430, 431, 900, len(log)]
    for start, stop in pairwise(seams):
        part, state = transform(log.rows(start, stop), theta, state)
        parts.append(part)
    assert direction == "apply" or (state is not None) == (Trait.MEMORY in effect.traits)
    known_at_seams = np.full(len(log), True)
    if effect.anticipates:
        # The last rows of a chunk are held until the next one comes.
        for stop in seams[1:-1]:
            known_at_seams[max(stop - 8, 0) : stop] = False
    for name in (None, *log.known):
        pieces = [p.readings if name is None else p.known[name] for p in parts]
        chunked = np.concatenate(pieces)[known_at_seams]
        at_once = (whole.readings if name is None else whole.known[name])[known_at_seams]
        np.testing.assert_allclose(chunked, at_once, rtol=1e-10, atol=1e-10)


def test_a_delay_reaches_back_across_a_seam_as_far_as_the_state_remembers() -> None:
    effect = TABLE["delay"]
    log = cell_log()
    theta = {"delay": np.array([0.4])}
    whole, _ = effect.apply(log, theta, None)
    first, state = effect.apply(log.rows(0, 600), theta, None)
    second, _ = effect.apply(log.rows(600, 1200), theta, state)
    assert REMEMBERED_ROWS / 40.0 > 0.4
    np.testing.assert_allclose(
        np.concatenate([first.known["com_m"], second.known["com_m"]]),
        whole.known["com_m"],
        atol=1e-12,
    )


@pytest.mark.parametrize("effect", [e for e in TABLE.values() if e.name != "dropped_samples"])
def test_recordings_in_one_log_share_no_memory(effect: Effect) -> None:
    log = log_for(effect)
    half = len(log) // 2
    theta = typical(effect, units(effect, log))
    first, second = log.rows(0, half), log.rows(half, len(log))
    restarted = Log(
        log.experiment,
        log.channels,
        np.concatenate([first.time_s, second.time_s - second.time_s[0]]),
        log.readings,
        log.known,
        log.block,
    )
    together, _ = effect.apply(restarted, theta, None)
    alone, _ = effect.apply(second, theta, None)
    np.testing.assert_allclose(together.readings[half:], alone.readings, atol=1e-12)


@pytest.mark.parametrize("effect", [TABLE[name] for name in ("hysteresis", "creep", "creep_slow")])
def test_memory_ends_where_nothing_was_recorded_between_two_sessions(effect: Effect) -> None:
    log = log_for(effect)
    half = len(log) // 2
    theta = typical(effect, units(effect, log))
    stamps = log.time_s + np.where(np.arange(len(log)) < half, 0.0, 3600.0)
    session = (np.arange(len(log)) >= half).astype(np.int64)
    days = replace(log, time_s=stamps, block=session)
    alone, _ = effect.apply(days.rows(half, len(log)), theta, None)
    for transform in (effect.apply, effect.remove):
        together, _ = transform(days, theta, None)
        first, state = transform(days.rows(0, half), theta, None)
        second, _ = transform(days.rows(half, len(log)), theta, state)
        both = np.concatenate([first.readings, second.readings])
        np.testing.assert_allclose(together.readings, both, atol=1e-12)
    np.testing.assert_allclose(
        effect.apply(days, theta, None)[0].readings[half:], alone.readings, atol=1e-12
    )
    # a hold with few rows is no break, and neither is a short pause between two gait cycles
    held, _ = effect.apply(replace(days, block=np.zeros_like(session)), theta, None)
    assert np.abs(held.readings[half:] - alone.readings).max() > 1e-6
    paused = replace(days, time_s=log.time_s)
    assert (
        np.abs(effect.apply(paused, theta, None)[0].readings[half:] - alone.readings).max() > 1e-6
    )


@pytest.mark.parametrize("effect", [TABLE[name] for name in ("hysteresis", "creep", "creep_slow")])
def test_memory_goes_on_where_the_next_session_comes_at_the_pace_of_the_readings(
    effect: Effect,
) -> None:
    log = log_for(effect)
    n, half = len(log), len(log) // 2
    theta = typical(effect, units(effect, log))
    session = (np.arange(n) >= half).astype(np.int64)
    by_hand = replace(log, time_s=np.arange(n, dtype=np.float64) * 20.0, block=session)
    one, _ = effect.apply(replace(by_hand, block=np.zeros_like(session)), theta, None)
    for cuts in ((0, n), (0, half, n), (0, half - 1, half, half + 1, n)):
        state, parts = None, []
        for start, stop in pairwise(cuts):
            part, state = effect.apply(by_hand.rows(start, stop), theta, state)
            parts.append(part.readings)
        np.testing.assert_allclose(np.concatenate(parts), one.readings, atol=1e-12)
    # three readings' time in which none was taken is a break
    paused = by_hand.time_s + 60.0 * session
    alone, _ = effect.apply(by_hand.rows(half, n), theta, None)
    broken, _ = effect.apply(replace(by_hand, time_s=paused), theta, None)
    np.testing.assert_allclose(broken.readings[half:], alone.readings, atol=1e-12)


def test_play_follows_the_definition_row_by_row() -> None:
    rng = np.random.default_rng(3)
    x = np.cumsum(rng.normal(size=(500, 3)), axis=0)
    radius = np.array([0.0, 0.7, 4.0])
    fresh = np.zeros(500, dtype=bool)
    fresh[[0, 200]] = True
    z = np.zeros(3)
    got = play(x, radius, np.zeros(3), fresh)
    for k in range(500):
        z = np.zeros(3) if fresh[k] else z
        z = np.minimum(np.maximum(z, x[k] - radius), x[k] + radius)
        np.testing.assert_array_equal(got[k], z)


def test_recurrence_follows_the_definition_row_by_row() -> None:
    rng = np.random.default_rng(4)
    decay, drive = rng.uniform(-0.9, 0.99, (300, 2)), rng.normal(size=(300, 2))
    s = start = np.array([5.0, -2.0])
    got = linear_recurrence(decay, drive, start)
    for k in range(300):
        s = decay[k] * s + drive[k]
        np.testing.assert_allclose(got[k], s, rtol=1e-10, atol=1e-10)


def test_a_hysteresis_loop_is_as_wide_as_its_width() -> None:
    load = np.concatenate([np.linspace(0, 20, 201), np.linspace(20, 0, 201)])
    log = Log("weights", ("left_fl",), np.arange(402.0), load[:, None], {}, np.zeros(402, int))
    theta = {"hysteresis_width": np.array([0.6]), "hysteresis_reach": np.array([2.0])}
    shown, _ = TABLE["hysteresis"].apply(log, theta, None)
    up, down = shown.readings[100, 0], shown.readings[301, 0]
    assert load[100] == load[301] == 10.0
    assert down - up == pytest.approx(0.6)


def test_creep_ends_at_its_share_of_the_load() -> None:
    log = Log("weights", ("left_fl",), np.arange(1000.0), np.full((1000, 1), 8.0), {},
              np.zeros(1000, int))  # fmt: skip
    theta = {"creep": np.array([0.05]), "creep_time": np.array([60.0])}
    shown, _ = TABLE["creep"].apply(log, theta, None)
    assert shown.readings[0, 0] == 8.0
    assert shown.readings[60, 0] == pytest.approx(8.0 * (1 + 0.05 * (1 - np.exp(-1))), rel=1e-9)
    assert shown.readings[-1, 0] == pytest.approx(8.4, rel=1e-6)


def test_a_lag_of_a_ramp_is_a_delay() -> None:
    t = np.arange(400) / 80.0
    log = Log("walk", ("left_fl",), t, 3.0 * t[:, None], {}, np.zeros(400, int))
    shown, _ = TABLE["sensor_lag"].apply(log, {"sensor_lag": np.array([0.05])}, None)
    assert shown.readings[-1, 0] == pytest.approx(3.0 * (t[-1] - 0.05), rel=1e-9)


def test_hours_of_hysteresis_are_undone_exactly() -> None:
    rows = 3600 * 80
    t = np.arange(rows) / 80.0
    load = 20.0 + 20.0 * np.sin(np.pi * t)[:, None] + np.zeros(len(CELLS))
    log = Log("walk", CELLS, t, load, {}, np.zeros(rows, int))
    theta = {"hysteresis_width": np.full(8, 0.5), "hysteresis_reach": np.full(8, 8.0)}
    distorted, _ = TABLE["hysteresis"].apply(log, theta, None)
    restored, _ = TABLE["hysteresis"].remove(distorted, theta, None)
    # half a width above or below the load, as a share of the largest one
    assert difference(log, distorted) == pytest.approx(0.25 / 40.0)
    assert difference(log, restored) < 1e-12


def test_a_misspelt_effect_names_the_nearest() -> None:
    with pytest.raises(UnknownEffectError, match="did you mean hysteresis"):
        find_effect("histeresis")
    assert find_effect("creep").name == "creep"


@pytest.mark.parametrize("name", sorted(EXPERIMENTS))
def test_what_an_experiment_calibrates_is_in_the_table_and_seen_by_it(name: str) -> None:
    experiment: Experiment = import_module(f"footcal_cli.core.experiments.{name}").EXPERIMENT
    assert experiment.name == name
    assert experiment.calibration
    for effect in experiment.calibration:
        assert name in find_effect(effect).experiments


def test_the_page_of_effects_is_that_of_the_table(repository: Path) -> None:
    page = (repository / "docs/effects.md").read_text(encoding="utf-8")
    for effect in TABLE.values():
        assert f"### {effect.name}\n\n{effect.formula}\n" in page, "run make effects-page"
        assert effect.remedy in page
        assert (repository / f"docs/figures/effects/{effect.name}.png").is_file()


def test_a_loss_of_angular_momentum_leaves_the_rest_of_it() -> None:
    """``L̇_shown = (1 − s) L̇``."""
    effect, log = find_effect("angular_momentum"), cell_log()
    shown, _ = effect.apply(log, {"angmom_loss": np.array([0.3])}, None)
    np.testing.assert_allclose(
        shown.known["angmom_rate_nm"], 0.7 * log.known["angmom_rate_nm"], rtol=1e-12
    )

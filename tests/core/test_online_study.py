"""What `online-replay` must show, on the physics engine's walks with cell drift.

The committed samples are the walks that thresholds were looked at on; with ``FOOTCAL_MOTIONS`` the
same figures come from motions, body streams and cells that nothing was looked at on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import stats

from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.evidence import check_consistency, rms
from footcal_cli.core.online.live import run_live
from footcal_cli.core.online.memory import Memory, MemoryOptions, replay_track, run_memory
from footcal_cli.core.online.noise import starting_noise
from footcal_cli.core.online.replay import (
    Replayed,
    corrected,
    errors_against,
)
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import low_pass
from footcal_cli.core.study.window import WindowRule, standing_weights
from footcal_cli.core.study.windows import best_smoothing, replay_window
from tests.core.physics_walks import (
    DRIFTING,
    MASS_KG,
    SPEEDS,
    TELEMETRY_S,
    motion_walk,
    motions,
    physics_walk,
    with_body_errors,
    with_hysteresis,
)
from tests.core.walk_data import Errors, G, Recording
from tests.core.walking import belief_of, walk_log

SETTLED_S = 5.0
OMEGAS = np.geomspace(10.0, 1e6, 11)
STILL = replace(DRIFTING, bias_walk=0.0, gain_walk=0.0)
FRESH = 2000
"""First seed of the walks nothing was looked at on."""
SOURCES = ("samples", "motions")


@dataclass(frozen=True)
class Outcome:
    """RMSE of (CoP m, each foot's CoP m, vGRF N) per method, and the filter's honesty."""

    scores: dict[str, FloatArray]
    nis: float
    worth: float
    nees: float
    covered: float
    memory: Memory
    recording: Recording


def study(recording: Recording, plate: float = 0.0, *, live: bool = False) -> Outcome:
    log: Log = walk_log(recording, TELEMETRY_S, causal=live)
    belief: Belief = belief_of(recording)
    # truth in the band of the cells: a causal low-pass delays both alike
    filtered = low_pass(recording.force, 80.0, causal=live)
    nothing = np.zeros(filtered.shape)
    raw_n = recording.counts * np.abs(belief.scale_n_per_count)
    noise = starting_noise(raw_n, channel_contact(log) == 0.0, MASS_KG * G)
    memory = (run_live if live else run_memory)(log, belief, MemoryOptions(noise=noise))
    truth = corrected("truth", memory.log, belief, nothing, filtered - belief.forces(log.readings))
    late = recording.cell_time > SETTLED_S

    def score(ours: Replayed) -> FloatArray:
        found = errors_against(ours, truth)
        return np.array(
            [
                rms(found.cop_m[late]),
                rms(found.foot_cop_m[late].reshape(-1, 2)),
                rms(found.vgrf_n[late]),
            ]
        )

    plates = np.full(filtered.shape, plate / 4.0)  # of each cell of a foot
    weights = standing_weights(log.rows(40, 150), belief, WindowRule())
    _, window = best_smoothing(log, belief, weights, truth, OMEGAS)
    _, static = best_smoothing(log, belief, weights, truth, OMEGAS, static=True)
    methods = {
        "before": corrected("before", log, belief, nothing, nothing),
        "floor": corrected(
            "true", memory.log, belief, recording.true_gain, recording.true_bias, plates
        ),
        "window": replay_window("window", log, belief, window),
        "static": replay_window("static", log, belief, static),
        "memory": replay_track("memory", memory, memory.track, belief),
        "smoother": replay_track("smoother", memory, memory.smoothed, belief),
    }
    true = np.concatenate([recording.true_gain, recording.true_bias], axis=1)
    true = true[memory.rows.last_sample]
    track = memory.track
    settled = memory.rows.time_s > SETTLED_S
    z = (track.values[settled, :16] - true[settled]) / track.sd[settled, :16]
    error = track.values[-1, :16] - true[-1]
    consistency = check_consistency(track)
    return Outcome(
        {name: score(one) for name, one in methods.items()},
        consistency.ratio,
        consistency.worth,
        float(error @ np.linalg.solve(track.covariance[:16, :16], error) / 16),
        float(np.mean(np.abs(z) < 1.96)),
        memory,
        recording,
    )


def ratios(outcomes: list[Outcome], ours: str, theirs: str, column: int) -> tuple[float, ...]:
    """Ratio of RMS over all walks with its 95 % interval, walks resampled in pairs."""
    a = np.array([o.scores[ours][column] for o in outcomes]) ** 2
    b = np.array([o.scores[theirs][column] for o in outcomes]) ** 2
    rng = np.random.default_rng(0)
    pick = rng.integers(0, a.size, (4000, a.size))
    draws = np.sqrt(a[pick].mean(axis=1) / b[pick].mean(axis=1))
    low, high = np.quantile(draws, [0.025, 0.975])
    return float(np.sqrt(a.mean() / b.mean())), float(low), float(high)


def honesty(outcomes: list[Outcome]) -> dict[str, tuple[float, float, float]]:
    """Mean NIS and NEES per degree of freedom with the bands they should lie in, and coverage."""
    worth = sum(o.worth for o in outcomes)
    ends = 16 * len(outcomes)

    def banded(value: float, dof: float) -> tuple[float, float, float]:
        low, high = (float(stats.chi2.ppf(q, dof)) / dof for q in (0.025, 0.975))
        return value, low, high

    return {
        "NIS": banded(float(np.mean([o.nis for o in outcomes])), worth),
        "NEES": banded(float(np.mean([o.nees for o in outcomes])), ends),
        "covered": (float(np.mean([o.covered for o in outcomes])), 0.90, 0.98),
    }


def show(title: str, outcomes: list[Outcome]) -> None:
    """The figures of a study, for the page of evidence (pytest -s)."""
    print(f"\n{title}: {len(outcomes)} walks")  # noqa: T201 - the study's answer
    for ours, theirs in (("memory", "window"), ("memory", "floor"), ("smoother", "window"),
                         ("static", "window"), ("memory", "before")):  # fmt: skip
        cells = [
            "{:.3f} [{:.3f}, {:.3f}]".format(*ratios(outcomes, ours, theirs, k)) for k in range(3)
        ]
        print(f"  {ours}/{theirs}: CoP {cells[0]}  foot {cells[1]}  vGRF {cells[2]}")  # noqa: T201
    for name in outcomes[0].scores:
        mean = np.sqrt(np.mean([o.scores[name] ** 2 for o in outcomes], axis=0))
        print(f"  {name}: {1e3 * mean[0]:.3f} mm {1e3 * mean[1]:.3f} mm {mean[2]:.3f} N")  # noqa: T201
    for name, (value, low, high) in honesty(outcomes).items():
        print(f"  {name} {value:.3f}, should be in [{low:.3f}, {high:.3f}]")  # noqa: T201


def recordings(source: str, count: int, errors: Errors, *, body: bool) -> list[Recording]:
    """Walks of the samples (seeds from 0) or of fresh motions (seeds from `FRESH`)."""
    first = FRESH if source == "motions" else 0
    seeds = range(first, first + count)
    drawn = [with_body_errors(errors, seed) if body else errors for seed in seeds]
    if source == "samples":
        return [
            physics_walk(SPEEDS[i % 3], one, seed)
            for i, (seed, one) in enumerate(zip(seeds, drawn, strict=True))
        ]
    paths = motions()
    return [
        motion_walk(paths[i % len(paths)], one, seed)
        for i, (seed, one) in enumerate(zip(seeds, drawn, strict=True))
    ]


@pytest.mark.slow
def test_one_walk_per_speed_shows_what_the_study_shows() -> None:
    outcomes = [study(r) for r in recordings("samples", 3, DRIFTING, body=True)]
    show("samples, one seed", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[0] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[0] < 0.45
    assert ratios(outcomes, "memory", "window", 2)[0] < 1.05
    assert ratios(outcomes, "memory", "floor", 0)[0] < 1.1
    assert 0.9 < np.mean([o.nis for o in outcomes]) < 1.1


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
def test_memory_against_the_window_at_its_best(source: str) -> None:
    outcomes = [study(r) for r in recordings(source, 18, DRIFTING, body=True)]
    show(f"{source}, drifting cells, body model 1.5 mm and 3 ms off", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[2] < 0.45
    assert ratios(outcomes, "memory", "window", 2)[2] < 1.05
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3
    honest = honesty(outcomes)
    for name in ("NEES", "covered"):
        value, low, high = honest[name]
        assert low < value < high
    # thousands of updates make a band narrower than any model of noise is true
    assert honest["NIS"][0] == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("errors", [DRIFTING, STILL], ids=["drifting", "still"])
def test_with_a_perfect_body_stream_memory_is_better_still(errors: Errors, source: str) -> None:
    outcomes = [study(r) for r in recordings(source, 9, errors, body=False)]
    show(f"{source}, body model exact, bias walk {errors.bias_walk} N", outcomes)
    # the best window is within 1.2 of the floor here: 0.65 of it lies below the floor
    assert ratios(outcomes, "memory", "window", 0)[2] < 1.0
    assert ratios(outcomes, "memory", "window", 1)[2] < 0.65
    assert ratios(outcomes, "memory", "window", 2)[2] < 1.05
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3
    # each at its own ωS; with a wrong body model both hardly move
    assert ratios(outcomes, "static", "window", 0)[1] > 2.0


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize(
    "errors", [replace(DRIFTING, delay=0.015), replace(DRIFTING, plate=1.5)], ids=["delay", "plate"]
)
def test_delay_and_plate_are_absorbed(errors: Errors, source: str) -> None:
    outcomes = [study(r, errors.plate) for r in recordings(source, 9, errors, body=False)]
    show(f"{source}, delay {errors.delay} s, plate {errors.plate} N", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[2] < 0.45
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
def test_live_memory_learns_from_the_past_alone(source: str) -> None:
    outcomes = [study(r, live=True) for r in recordings(source, 9, DRIFTING, body=True)]
    show(f"{source}, live", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[2] < 0.6
    assert ratios(outcomes, "memory", "window", 2)[2] < 1.05
    assert 0.88 < honesty(outcomes)["covered"][0] < 0.98


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
def test_a_cell_that_lags_behind_its_load_does_not_make_memory_worse(source: str) -> None:
    outcomes = [
        study(with_hysteresis(r, (3 + 5 * i) % 8, 0.8))
        for i, r in enumerate(recordings(source, 9, STILL, body=False))
    ]
    show(f"{source}, one cell with 0.8 N of hysteresis nobody told of", outcomes)
    # a loop is no gain and no bias: the true ones are the yardstick. A window whose weight was
    # chosen by the truth follows the loop within half a second (CoP 0.7 of that yardstick); memory
    # uses totals up to the frequency of steps alone where errors repeat, for honest intervals
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.05
    assert ratios(outcomes, "memory", "floor", 2)[2] < 1.05
    assert ratios(outcomes, "memory", "window", 2)[2] < 1.05
    value, low, high = honesty(outcomes)["covered"]
    assert low < value < high


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES)
def test_a_jump_is_alarmed_and_recovered(source: str) -> None:
    recovered, delays = [], []
    for i in range(10):
        when, cell = 20.0 + 1.7 * i, i % 8
        errors = replace(DRIFTING, jumps=((cell, when, 2.0),))
        recording = recordings(source, i + 1, errors, body=False)[-1]
        outcome = study(recording)
        jumps = [j for j in outcome.memory.jumps if abs(j.onset_s - when) < 0.5]
        assert jumps
        rows, track = outcome.memory.rows, outcome.memory.track
        true = recording.true_bias[rows.last_sample, cell]
        off = np.abs(track.values[:, 8 + cell] - true)
        late = np.flatnonzero((rows.time_s > when) & (off > 0.3))
        recovered.append(rows.time_s[late[-1]] - when if late.size else 0.0)
        delays.append(jumps[0].found_s - when)
    print(  # noqa: T201 - the study's answer
        f"\n{source}, a jump of 2 N: alarmed 10 of 10, {np.median(delays):.2f} s later (at most "
        f"{max(delays):.2f}); within 0.3 N for good after {np.median(recovered):.2f} s (at most "
        f"{max(recovered):.2f})"
    )
    assert max(recovered) < 5.0

"""What `online-replay` must show, on the physics walks at three speeds with cell drift."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.log import Log
from footcal_cli.core.online.evidence import check_consistency, rms
from footcal_cli.core.online.memory import Memory, MemoryOptions, replay_track, run_memory
from footcal_cli.core.online.noise import starting_noise
from footcal_cli.core.online.replay import (
    Replayed,
    best_smoothing,
    corrected,
    errors_against,
    replay_window,
)
from footcal_cli.core.online.rows import Belief
from footcal_cli.core.online.window import Weights, WindowRule, run_window_fast, standing_weights
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.signals import low_pass
from tests.core.physics_walks import (
    DRIFTING,
    MASS_KG,
    SPEEDS,
    TELEMETRY_S,
    physics_walk,
    with_body_errors,
)
from tests.core.walk_data import Errors, G, Recording
from tests.core.walking import belief_of, walk_log

SETTLED_S = 5.0
OMEGAS = np.geomspace(10.0, 1e6, 11)


@dataclass(frozen=True)
class Outcome:
    """RMSE of (CoP m, each foot's CoP m, vGRF N) per method, and the filter's honesty."""

    scores: dict[str, FloatArray]
    baseline: dict[str, FloatArray]
    nis: float
    nees: float
    covered: float
    memory: Memory
    recording: Recording


def study(recording: Recording, plate: float = 0.0) -> Outcome:
    log: Log = walk_log(recording, TELEMETRY_S)
    belief: Belief = belief_of(recording)
    filtered = low_pass(recording.force, 80.0)
    nothing = np.zeros(filtered.shape)
    raw_n = recording.counts * np.abs(belief.scale_n_per_count)
    noise = starting_noise(raw_n, channel_contact(log) == 0.0, MASS_KG * G)
    memory = run_memory(log, belief, MemoryOptions(noise=noise))
    truth = corrected("truth", memory.log, belief, nothing, filtered - belief.forces(log.readings))
    late = recording.cell_time > SETTLED_S

    def score(ours: Replayed, against: Replayed) -> FloatArray:
        found = errors_against(ours, against)
        return np.array(
            [
                rms(found.cop_m[late]),
                rms(found.foot_cop_m[late].reshape(-1, 2)),
                rms(found.vgrf_n[late]),
            ]
        )

    plates = np.full((len(log), 2), plate)
    floor = corrected("true", memory.log, belief, recording.true_gain, recording.true_bias, plates)
    weights = standing_weights(log.rows(40, 150), belief, WindowRule())
    omega, window = best_smoothing(log, belief, weights, truth, OMEGAS)
    same = Weights(weights.force, weights.cop, omega)
    methods = {
        "before": corrected("before", log, belief, nothing, nothing),
        "floor": floor,
        "window": replay_window("window", log, belief, window),
        "han": replay_window("han", log, belief, run_window_fast(log, belief, same, static=True)),
        "memory": replay_track("memory", memory, memory.track, belief),
        "smoother": replay_track("smoother", memory, memory.smoothed, belief),
    }
    true = np.concatenate([recording.true_gain, recording.true_bias], axis=1)
    true = true[memory.rows.last_sample]
    track = memory.track
    z = (track.values[:, :16] - true) / track.sd[:, :16]
    error = track.values[-1, :16] - true[-1]
    return Outcome(
        {name: score(one, truth) for name, one in methods.items()},
        {name: score(one, floor) for name, one in methods.items() if name != "floor"},
        check_consistency(track).ratio,
        float(error @ np.linalg.solve(track.covariance[:16, :16], error) / 16),
        float(np.mean(np.abs(z[memory.rows.time_s > SETTLED_S]) < 1.96)),
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


def show(title: str, outcomes: list[Outcome]) -> None:
    """The figures of a study, for the page of evidence (pytest -s)."""
    print(f"\n{title}: {len(outcomes)} walks")  # noqa: T201 - the study's answer
    for ours, theirs in (("memory", "window"), ("memory", "floor"), ("smoother", "window"),
                         ("han", "window"), ("memory", "before")):  # fmt: skip
        cells = [
            "{:.3f} [{:.3f}, {:.3f}]".format(*ratios(outcomes, ours, theirs, k)) for k in range(3)
        ]
        print(f"  {ours}/{theirs}: CoP {cells[0]}  foot {cells[1]}  vGRF {cells[2]}")  # noqa: T201
    for name in outcomes[0].scores:
        mean = np.sqrt(np.mean([o.scores[name] ** 2 for o in outcomes], axis=0))
        print(f"  {name}: {1e3 * mean[0]:.3f} mm {1e3 * mean[1]:.3f} mm {mean[2]:.3f} N")  # noqa: T201
    nis, nees, covered = (
        np.mean([getattr(o, n) for o in outcomes]) for n in ("nis", "nees", "covered")
    )
    print(f"  NIS {nis:.3f} NEES {nees:.2f} covered {covered:.3f}")  # noqa: T201


def walks(seeds: range, errors: Errors, *, body: bool, plate: float = 0.0) -> list[Outcome]:
    found = []
    for seed in seeds:
        for k, speed in enumerate(SPEEDS):
            drawn = with_body_errors(errors, 10 * seed + k) if body else errors
            found.append(study(physics_walk(speed, drawn, 10 * seed + k), plate))
    return found


def test_one_walk_per_speed_shows_what_the_study_shows() -> None:
    outcomes = walks(range(1), DRIFTING, body=True)
    show("one seed", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[0] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[0] < 0.6
    assert ratios(outcomes, "memory", "window", 2)[0] < 1.05
    assert ratios(outcomes, "memory", "floor", 0)[0] < 1.3


@pytest.mark.slow
def test_memory_against_the_window_at_its_best_over_ten_seeds() -> None:
    outcomes = walks(range(10), DRIFTING, body=True)
    show("drifting cells, body model 1.5 mm and 3 ms off", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 0.65
    assert ratios(outcomes, "memory", "window", 1)[2] < 0.45
    assert ratios(outcomes, "memory", "window", 2)[2] < 1.05
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3
    assert np.mean([o.nis for o in outcomes]) == pytest.approx(1.0, abs=0.1)
    assert 0.90 <= np.mean([o.covered for o in outcomes]) <= 0.98


@pytest.mark.slow
def test_with_a_perfect_body_stream_memory_still_wins() -> None:
    outcomes = walks(range(10), DRIFTING, body=False)
    show("drifting cells, body model exact", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 1.0
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3
    # with a wrong body model the best window hardly moves, and Han's in the same window neither
    assert ratios(outcomes, "han", "window", 0)[1] > 3.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "errors", [replace(DRIFTING, delay=0.015), replace(DRIFTING, plate=1.5)], ids=["delay", "plate"]
)
def test_delay_and_plate_are_absorbed(errors: Errors) -> None:
    outcomes = walks(range(5), errors, body=False, plate=errors.plate)
    show(f"delay {errors.delay} s, plate {errors.plate} N", outcomes)
    assert ratios(outcomes, "memory", "window", 0)[2] < 0.65
    assert ratios(outcomes, "memory", "floor", 0)[2] < 1.3


@pytest.mark.slow
def test_a_jump_is_alarmed_and_recovered() -> None:
    recovered = []
    for seed in range(10):
        speed = SPEEDS[seed % 3]
        when, cell = 20.0 + 1.7 * seed, seed % 8
        errors = replace(DRIFTING, jumps=((cell, when, 2.0),))
        outcome = study(physics_walk(speed, errors, seed))
        jumps = [j for j in outcome.memory.jumps if abs(j.onset_s - when) < 0.5]
        assert jumps
        rows, track = outcome.memory.rows, outcome.memory.track
        true = outcome.recording.true_bias[rows.last_sample, cell]
        off = np.abs(track.values[:, 8 + cell] - true)
        late = np.flatnonzero((rows.time_s > when) & (off > 0.3))
        recovered.append(rows.time_s[late[-1]] - when if late.size else 0.0)
        told = [(j.name, j.onset_s - when, j.found_s - when, j.size) for j in jumps]
        print(seed, rows.names[8 + cell], told, recovered[-1])  # noqa: T201
    assert max(recovered) < 5.0

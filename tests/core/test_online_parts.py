"""A walk in parts is the walk as a whole."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from footcal_cli.core.online.comparison import ReplayedWalk, ReplaySettings, compare
from footcal_cli.core.online.filter import Guards, Track
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.parts import WalkInParts, WalkPart
from footcal_cli.core.online.streams import BodyStream, Merged, MergeRule, SensorStream
from tests.core.walk_data import CELLS_FOOT, CHANNELS, Errors, G, Recording, make_walk, record
from tests.core.walking import belief_of

# a threshold low enough that hypotheses of jumps, and one jump near a seam, cross the seams
ERRORS = Errors(
    bias_walk=0.03, gain_walk=4e-4, quantum=0.25, delay=0.022, com_offset=(0.003, -0.002),
    jumps=((2, 19.8, 2.0),),
)  # fmt: skip
OPTIONS = MemoryOptions(learnt=(), align=False, plate=False, guards=Guards(jump_threshold=20.0))
SETTINGS = ReplaySettings(memory=OPTIONS)
PART, BEFORE, AHEAD = 800, 400, 1200
"""Samples: 10 s with 5 s before and 15 s ahead."""


def merged_of(rec: Recording) -> Merged:
    zero = np.zeros((len(rec.body_time), 2, 1))
    body = BodyStream(
        rec.body_time, rec.com, rec.acc, rec.angmom_rate,
        np.concatenate([rec.feet, zero], axis=2), rec.yaw,
    )  # fmt: skip
    sensors = SensorStream(rec.cell_time, rec.counts, CHANNELS)
    cells, rule = (CELLS_FOOT, CELLS_FOOT), MergeRule(delay_s=0.02)
    return merge_cells(sensors, body, belief_of(rec), cells, rec.mass, G, rule=rule)


def parts_of(merged: Merged) -> Iterator[WalkPart]:
    n = len(merged.log)
    for start in range(0, n, PART):
        stop = min(start + PART, n)
        first = max(start - BEFORE, 0)
        yield WalkPart(merged.part(first, min(stop + AHEAD, n)), start - first, stop - first)


@pytest.fixture(scope="module")
def recording() -> Recording:
    return record(make_walk(0.04, 45.0, seed=3), ERRORS, seed=3)


@pytest.fixture(scope="module")
def whole(recording: Recording) -> ReplayedWalk:
    rng = np.random.default_rng(0)
    return compare(merged_of(recording), belief_of(recording), SETTINGS, rng=rng)


@pytest.fixture(scope="module")
def in_parts(recording: Recording) -> tuple[list[ReplayedWalk], ReplayedWalk]:
    parts = list(parts_of(merged_of(recording)))
    walk = WalkInParts(belief_of(recording), SETTINGS, parts[0])
    found = [walk.take(part) for part in parts]
    return found, walk.finish(np.random.default_rng(0))


def joined(found: list[ReplayedWalk], inflated: bool = False) -> Track:
    """Tracks of the parts, each without the update that it took over from the one before."""
    tracks = []
    for k, part in enumerate(found):
        track = part.memory.track.chosen(slice(1 if k else 0, None))
        factor = 1.0 if inflated else 1.0 / part.memory.repeated
        tracks.append(track.inflated(factor))
    together = tracks[0]
    for track in tracks[1:]:
        together = together.followed_by(track)
    return together


def test_the_filter_in_parts_is_the_filter_over_the_whole_walk(
    in_parts: tuple[list[ReplayedWalk], ReplayedWalk], whole: ReplayedWalk
) -> None:
    found, end = in_parts
    track, one = joined(found), whole.memory.track
    assert [jump.name for jump in one.jumps] == [f"{CHANNELS[2]}.bias"]
    for ours, theirs in zip(end.memory.jumps, one.jumps, strict=True):
        assert (ours.name, ours.onset_s, ours.found_s) == (
            theirs.name, theirs.onset_s, theirs.found_s,
        )  # fmt: skip
    unit = whole.memory.rows.prior_sd
    np.testing.assert_allclose(track.values / unit, one.values / unit, rtol=0, atol=1e-9)
    sd = one.inflated(1.0 / whole.memory.repeated).sd
    np.testing.assert_allclose(track.sd, sd, rtol=1e-7)
    np.testing.assert_allclose(track.nis, one.nis, rtol=1e-7, atol=1e-9)
    # and so is what it claims at the end
    assert end.memory.repeated == pytest.approx(whole.memory.repeated, rel=1e-9)
    np.testing.assert_allclose(
        end.memory.track.covariance, one.covariance, rtol=1e-6, atol=1e-9 * np.max(one.covariance)
    )


def test_samples_errors_and_reasons_add_up_to_those_of_the_whole(
    in_parts: tuple[list[ReplayedWalk], ReplayedWalk], whole: ReplayedWalk
) -> None:
    found, end = in_parts
    forces = np.concatenate([part.replayed["memory"].forces_n for part in found])
    np.testing.assert_allclose(forces, whole.replayed["memory"].forces_n, atol=1e-8)
    np.testing.assert_array_equal(np.concatenate([part.cycle for part in found]), whole.cycle)
    reasons = np.concatenate([part.validity.reason for part in found])
    np.testing.assert_array_equal(reasons, whole.validity.reason)
    assert dict(end.rejected) == dict(whole.rejected)
    assert end.taught == whole.taught
    for quantity in ("cop", "vgrf"):
        # the reference takes the delay out that the smoother states: nearly the same one
        for method, tolerance in (("before", 0.02), ("memory", 0.02), ("smoother", 0.03)):
            ours, theirs = (one.of(method, "motion") for one in (end, whole))
            assert ours.rms(quantity) == pytest.approx(theirs.rms(quantity), rel=tolerance)
            assert ours.whole[quantity].count == theirs.whole[quantity].count
            assert ours.cycles(quantity).size == theirs.cycles(quantity).size
    assert end.consistency.ratio == pytest.approx(whole.consistency.ratio, rel=1e-9)
    assert end.consistency.updates == whole.consistency.updates


def test_the_smoother_of_a_part_knows_nearly_what_the_whole_walk_knows(
    in_parts: tuple[list[ReplayedWalk], ReplayedWalk], whole: ReplayedWalk
) -> None:
    found, _ = in_parts
    back = [part.memory.smoothed.chosen(slice(1 if k else 0, None)) for k, part in enumerate(found)]
    values = np.concatenate([track.values for track in back])
    inflation = np.concatenate(
        [np.full(t.time_s.size, p.memory.repeated) for t, p in zip(back, found, strict=True)]
    )
    sd = np.concatenate([track.sd for track in back]) / np.sqrt(inflation)[:, None]
    smoothed = whole.memory.smoothed
    whole_sd = smoothed.sd / np.sqrt(whole.memory.repeated)
    # what does not change along a walk, such as a filter of the body's stream, 15 s ahead cannot
    # know as well as the whole walk does: gains and biases are compared
    cells = slice(0, 2 * len(CHANNELS))
    ratio = (sd / whole_sd)[:, cells]
    assert np.all(ratio > 1 - 1e-6)
    assert np.sqrt(np.mean(ratio**2)) < 1.05
    # an estimate from part of the data differs from that of all by the difference of variances
    expected = np.sqrt(np.mean(ratio**2 - 1))
    apart = ((values - smoothed.values) / whole_sd)[:, cells]
    assert np.sqrt(np.mean(apart**2)) < 1.5 * expected
    filtered = ((whole.memory.track.values - smoothed.values) / whole_sd)[:, cells]
    assert np.sqrt(np.mean(apart**2)) < 0.3 * np.sqrt(np.mean(filtered**2))

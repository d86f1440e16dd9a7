"""Findings on raw data: each fault is found, and healthy data stay quiet."""

from __future__ import annotations

import re
import tracemalloc

import numpy as np
import pytest

from footcal_cli.core.checks.siblings import check_dead_channels, check_loose_channels
from footcal_cli.core.quality import (
    check_clock,
    check_duplicate_channels,
    check_frozen,
    check_load_unit,
    check_order,
    check_repeats_across_channels,
    check_stream,
)
from footcal_cli.core.readings import (
    check_codes,
    check_known_loads,
    find_glitches,
    lost_sign,
    signed,
)

LOADS = np.array([0.0, 1.0, 2.0, 5.0])


def independent_cells(seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        f"cell{i}": np.round(
            8.3e6 + 4e4 * rng.standard_normal() - 3e4 * (1 + 0.02 * rng.standard_normal()) * LOADS
        )
        for i in range(8)
    }


def test_independent_cells_raise_no_alarm() -> None:
    loads = dict.fromkeys((f"cell{i}" for i in range(8)), LOADS)
    alarms = [check_repeats_across_channels(independent_cells(s), loads) for s in range(200)]
    assert not any(alarms)


def test_copied_rows_are_found() -> None:
    cells = independent_cells(1)
    loads = dict.fromkeys(cells, LOADS)
    cells["cell3"] = cells["cell2"].copy()
    cells["cell5"] = cells["cell2"].copy()
    (finding,) = check_repeats_across_channels(cells, loads)
    assert finding.code == "readings_repeat_across_channels"
    assert "in 3 channels" in finding.sentence


@pytest.mark.parametrize("code", [2**23 - 1, -(2**23), 2**24 - 1])
def test_end_codes_are_saturation(code: int) -> None:
    counts = np.array([8.0e6, 8.1e6, float(code)])
    assert "saturated_codes" in {f.code for f in check_codes("c", counts, bits=24)}


@pytest.mark.parametrize("code", [2**23 - 1, 2**24 - 1, 0])
def test_a_reading_that_others_pass_is_no_end(code: int) -> None:
    """What a converter clips to is the last of its readings; mid-scale is crossed by chance."""
    counts = np.array([-3.0e6, float(code), 2.0e7])
    assert not check_codes("c", counts, bits=24)


def test_a_healthy_channel_has_no_alarm() -> None:
    codes = {f.code for f in check_codes("c", np.array([8.0e6, 8.1e6, 8.2e6]), bits=24)}
    assert codes == {"offset_binary"}
    assert not check_codes("c", np.array([1000.0, 2000.0, 3000.0]), bits=24)


def test_a_stuck_channel_is_an_alarm() -> None:
    (finding,) = check_codes("c", np.full(5, 1234.0), bits=24)
    assert finding.code == "stuck_channel"


def test_grams_taken_for_newtons_and_back() -> None:
    assert not check_load_unit(LOADS, (0.0, 53.0), None)
    assert check_load_unit(LOADS * 1e4, (0.0, 53.0), None)[0].code == "implausible_unit"
    assert check_load_unit(LOADS * 1e-3, None, 53.0)[0].code == "implausible_unit"
    assert not check_load_unit(LOADS, None, None)


def test_a_duplicated_stream_is_found_though_samples_are_lost() -> None:
    rng = np.random.default_rng(0)
    readings = rng.standard_normal((200, 3))
    assert not check_duplicate_channels(readings, ["a", "b", "c"])
    readings[:, 2] = readings[:, 0]
    readings[5, 2] = np.nan
    (finding,) = check_duplicate_channels(readings, ["a", "b", "c"])
    assert finding.where == "a, c"


def test_a_healthy_clock_is_quiet_and_faults_are_named() -> None:
    time_s = np.linspace(0.0, 499 * 0.0125, 500) + 1e-4 * np.random.default_rng(0).standard_normal(
        500
    )
    assert not check_clock(time_s, "cells")
    back = time_s.copy()
    back[200] = back[190]
    assert "time_goes_back" in {f.code for f in check_clock(back, "cells")}
    twice = time_s.copy()
    twice[100] = twice[99]
    assert "duplicate_stamps" in {f.code for f in check_clock(twice, "cells")}
    (gap,) = check_clock(np.delete(time_s, slice(100, 140)), "cells")
    assert gap.code == "gaps"
    shown = re.search(r"longest ([\d.]+) s", gap.sentence)
    assert shown is not None
    assert float(shown[1]) == pytest.approx(41 * 0.0125, abs=1e-3)


def test_stragglers_are_a_warning_and_shuffled_rows_an_alarm() -> None:
    time_s = 0.01 * np.arange(500.0)
    late = time_s.copy()
    late[200] = time_s[190] + 1e-3
    joined = np.concatenate([time_s, time_s])
    shuffled = np.random.default_rng(0).permutation(time_s)
    found = [check_order(stamps, "cells") for stamps in (time_s, late, joined, shuffled)]
    assert [[f.severity for f in each] for each in found] == [[], ["warning"], ["alarm"], ["alarm"]]


@pytest.mark.parametrize("period_s", [0.005, 0.008, 0.01])
def test_late_stamps_are_no_gaps_and_lost_samples_among_them_are(period_s: float) -> None:
    """Telemetry of [NAO]: stamps 20 ± 4 ms late, in order, one packet after the other."""
    rng = np.random.default_rng(4)
    longest = []
    for _ in range(20):
        late = 0.02 + 0.004 * rng.standard_normal(6000)
        queue = 5e-4 * np.arange(6000)
        taken = period_s * np.arange(6000)
        stamps = np.maximum.accumulate(taken + np.maximum(late, 0.0) - queue) + queue
        longest.append(np.diff(stamps).max() / np.median(np.diff(stamps)))
        assert not check_clock(stamps, "body")
        lost = np.delete(stamps, slice(3000, 3008))
        (gap,) = check_clock(lost, "body")
        assert gap.sentence.startswith("1 gap,")
    if period_s < 0.01:
        assert max(longest) > 3.5, "no interval was long: nothing was tested"


def test_a_stall_that_is_made_up_for_is_no_gap() -> None:
    stamps = 0.01 * np.arange(500.0)
    stamps[200:206] = stamps[206] - 5e-4 * np.arange(6, 0, -1)
    assert np.diff(stamps).max() > 0.06
    assert not check_clock(stamps, "body")


def test_a_stream_tells_lost_and_stuck_samples() -> None:
    rng = np.random.default_rng(0)
    time_s = np.linspace(0.0, 799 * 0.0125, 800)
    readings = np.round(100 * rng.standard_normal((800, 4)))
    names = ["a", "b", "c", "d"]
    assert not check_stream(time_s, readings, names)
    readings[300:500, 1] = readings[300, 1]
    readings[10:40, 2] = np.nan
    found = {(f.code, f.where) for f in check_stream(time_s, readings, names)}
    assert found == {("stuck_channel", "b"), ("lost_samples", "c")}


def test_checks_of_a_long_log_need_less_memory_than_a_copy_of_it() -> None:
    """Eight hours of eight cells are 0.15 GB: copies of all of them at once add up."""
    time_s = np.arange(200_000) / 80.0
    step = np.where(time_s % 1.2 < 0.6, 0.0, 5e4)
    noise = np.random.default_rng(3).normal(0.0, 20.0, (time_s.size, 8))
    values = step[:, None] * np.linspace(0.8, 1.2, 8) + noise
    names = [f"left_{i}_counts" for i in range(8)]
    tracemalloc.start()
    found = [*check_frozen(time_s, values, "log"), *check_stream(time_s, values, names)]
    found += [*check_loose_channels(values, names), *check_dead_channels(values, names)]
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert not found
    assert most < 0.6 * values.nbytes


@pytest.mark.parametrize("size", [100, 1000, 10_000])
def test_a_few_wild_samples_are_glitches_of_a_short_log_too(size: int) -> None:
    rng = np.random.default_rng(size)
    noise = rng.standard_normal(size)
    assert not find_glitches(noise).any()
    wild = rng.choice(size, 8, replace=False)
    noise[wild] = 50.0
    np.testing.assert_array_equal(np.flatnonzero(find_glitches(noise)), np.sort(wild))


def test_negative_codes_without_their_sign_are_told_from_two_ends_of_a_range() -> None:
    rng = np.random.default_rng(4)
    levels = np.repeat([4400.0, -140_000.0, -284_000.0, -572_000.0], 6)
    true = levels + rng.normal(0.0, 40.0, levels.size).round()
    for bits in (22, 24, 32):
        read = np.mod(true, 2.0**bits)
        assert lost_sign(read) == 2.0**bits
        np.testing.assert_array_equal(signed(read, 2.0**bits), true)
        assert "sign_lost" in {f.code for f in check_codes("a", read, 24)}
    for bits in (16, 18, 20):
        small = np.round(true / 2.0 ** (22 - bits))
        assert lost_sign(np.mod(small, 2.0**bits)) == 2.0**bits
    for bits in (16, 18, 20, 22, 24):  # ladders over all of a converter's range
        for loads in (np.arange(3.0), np.arange(9.0), np.array([0.0, 1, 2, 5, 10, 20])):
            ladder = np.repeat(loads / loads[-1], 5) * 0.95 * 2.0**bits
            assert lost_sign(np.round(ladder + rng.uniform(0.0, 30.0, ladder.size))) == 0.0
    assert lost_sign(true) == 0.0
    full = np.repeat([500.0, 65_000.0], 6) + rng.normal(0.0, 20.0, 12).round()  # 16 bits, all of it
    assert lost_sign(full) == 0.0
    assert lost_sign(np.repeat([0.0, 8e6, 8.1e6, 2.0**24 - 1], 4)) == 0.0  # end codes among counts


def test_a_few_glitches_do_not_make_a_cell_dead() -> None:
    rng = np.random.default_rng(5)
    load = np.repeat([0.0, 5.0, 10.0, 20.0], 30)
    counts = 8.2e6 - 3e4 * load + rng.normal(0.0, 40.0, load.size)
    counts[rng.permutation(load.size)[:5]] = [0, 0, 16777215, 0, 16777215]
    assert not check_known_loads(load, counts, "a")
    dead = rng.normal(8.2e6, 40.0, load.size)
    assert [f.code for f in check_known_loads(load, dead, "a")] == ["dead_cell"]

"""Streams of cells: words of a converter, hum, cells that let go, feet that do not fit together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.checks.lines import moved_between_ends
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.quality import Finding, listed
from footcal_cli.core.signals import stretches

_SUB_BINS, _FILLED_BLOCKS = 2, 3
"""A bit that is lost leaves every other block of readings empty; so many halves of blocks must be
filled in all their quarters, which a sound channel does once in 10⁵ logs."""
_FEWEST, _FEWEST_SWINGS = 200, 3
COARSE_STEPS = 100
"""Steps of a power of ten over the range, below which digits were lost in writing."""
LATE_S, LATEST_S = 0.05, 0.4
HALF = 0.5
"""A foot is late where its shift leaves so little of the variance of the whole force."""
WINDOW_S = 2.0
NOT_CARRIED = 0.15
"""Share of the weight that means over `WINDOW_S` may lack: over it, steps average out."""
DRIFTS, DRIFTS_SD = 0.025, 8.0
"""Share of the weight, and sd of the means over `WINDOW_S`, by which the whole force may drift."""
GAINS = 0.2
"""Feet that are not calibrated may differ so much in gain: load that moves between them shows."""
LET_GO, FOLLOWS = 1.5, 0.8
"""Change of a cell's gain beside its siblings, and the correlation in each half that shows it."""
_MOST_FITTED = 200_000
"""Rows of a long log that a gain is fitted to."""
_MOST_HEARD = 2**20
"""Samples in which a line is looked for: the first hours of a long log."""
HUM_BY_CHANCE, HUM_SHARE, HUM_OTHERS = 1e-8, 0.01, 0.2
"""Fisher's probability of a line, its amplitude over the range, and its power beside others'."""
HUM_ALONE = 8.0
"""Its power over the next line's: harmonics of a gait come in rows of nearly the same size."""
ZERO_MOVES, ZERO_SD = 0.005, 8.0
"""Share of the weight, and sd by neighbouring swings, by which a cell's zero may move in a log."""
_APART, _BY_CHANCE = 3.0, 0.05
"""Times the usual range, and chance of a trend, by which one cell's zeros go their own way."""
LIFTED_M, EXCHANGED_SHARE = 0.006, 0.7
"""A foot is in the air above this height; it cannot carry that share of the robot there."""


@listed
def check_word(name: str, counts: FloatArray) -> Iterator[Finding]:
    """Find bits that never change, and digits that were lost in writing."""
    good = counts[np.isfinite(counts)]
    if good.size < _FEWEST or not (good == np.rint(good)).all() or not np.ptp(good) > 0:
        return
    words, span = good.astype(np.int64), float(np.ptp(good))
    step = 100
    while (words % (10 * step) == 0).all():
        step *= 10
    if (words % step == 0).all() and span / step < COARSE_STEPS:
        yield Finding(
            "few_digits", "warning", name,
            f"all readings are multiples of {step:,}, {span / step:.0f} steps over their range",
            "write readings with all their digits; a converter does not count in powers of ten",
        )  # fmt: skip
        return
    for bit in range(int(np.log2(span)), _SUB_BINS, -1):
        if _lost(words, bit):
            yield Finding(
                "bit_lost", "alarm", name,
                f"bit {bit} of its readings ({2**bit:,} counts) never changes, though bits above "
                "and below it do",
                "check how the logger puts the bytes of a reading together, and the data line",
            )  # fmt: skip
            return


def _lost(words: np.ndarray, bit: int) -> bool:
    """Whether readings fill halves of blocks of two to the `bit` and leave the others empty."""
    if np.ptp((words >> bit) & 1):
        return False
    quarters = np.unique(words >> (bit - _SUB_BINS))
    _, filled = np.unique(quarters >> _SUB_BINS, return_counts=True)
    return int((filled == 2**_SUB_BINS).sum()) >= _FILLED_BLOCKS


@listed
def check_feet_together(
    time_s: FloatArray, foot_n: FloatArray, names: Sequence[str], weight_n: float
) -> Iterator[Finding]:
    """Compare feet that together carry a weight which stays the same.

    Parameters
    ----------
    foot_n
        Vertical force of each foot, zeros unknown, shape (n, feet).
    weight_n
        Of the robot.
    """
    good = np.isfinite(foot_n).all(axis=1)
    step = float(np.median(np.diff(time_s))) if time_s.size > 2 else 0.0
    if good.sum() < _FEWEST or not step > 0:
        return
    times, force = time_s[good], foot_n[good]
    if len(names) == 2:
        late = list(_late(force, names, step))
        yield from late
        if late:
            return
    width = max(round(WINDOW_S / step), 1)
    pieces = len(force) // width
    if pieces < 5:
        return
    foot = force[: pieces * width].reshape(pieces, width, -1).mean(axis=1)
    total = foot.sum(axis=1)
    start = times[: pieces * width : width]
    off = (total - np.median(total)) / weight_n
    # a change of the whole load, beyond what feet of different gain make of load that moves
    moved = np.abs(foot - np.median(foot, axis=0)).sum(axis=1) / (2.0 * weight_n)
    wrong = np.abs(off) > NOT_CARRIED + GAINS * moved
    if wrong.any() and np.mean(wrong) < HALF:
        worst = int(np.argmax(np.abs(off) * wrong))
        first, last = next(s for s in stretches(wrong) if s[0] <= worst < s[1])
        how = f"{100 * abs(off[worst]):.0f} % of the weight {'less' if off[worst] < 0 else 'more'}"
        yield Finding(
            "weight_not_constant", "warning", "all feet",
            f"for {(last - first) * width * step:.3g} s from {start[first]:.6g} s on the feet "
            f"carry {how} than otherwise",
            "look whether somebody held the robot, or something lay on it; cut these seconds out",
        )  # fmt: skip
        return
    design = np.column_stack([np.ones(pieces), np.linspace(0.0, 1.0, pieces)])
    each = np.linalg.lstsq(design, foot, rcond=None)[0]
    solved = each.sum(axis=1)
    scatter = float(np.std(total - design @ solved)) * np.sqrt(12.0 / pieces)
    least = DRIFTS * weight_n + GAINS * float(np.abs(each[1]).sum()) / 2.0
    if abs(solved[1]) > max(least, DRIFTS_SD * scatter):
        yield Finding(
            "weight_drifts", "warning", "all feet",
            f"the force of all feet together drifts by {solved[1]:.3g} N over the log, "
            f"{100 * abs(solved[1]) / weight_n:.0f} % of the weight",
            "let the cells warm up before the recording; a cell that creeps does the same",
        )  # fmt: skip


@listed
def check_zeros(
    forces_n: FloatArray, in_air: BoolArray, names: Sequence[str], weight_n: float
) -> Iterator[Finding]:
    """Compare what cells read in the first and in the last quarter of their swings: their zeros.

    Parameters
    ----------
    forces_n
        Of the cells, shape (n, c).
    in_air
        Whether the foot of each cell swings, shape (n, c).
    names
        Of the cells.
    weight_n
        Of the robot.
    """
    for i, name in enumerate(names):
        swings = [
            forces_n[start + (stop - start) // 4 : stop - (stop - start) // 4, i]
            for start, stop in stretches(in_air[:, i])
        ]
        means = [float(np.mean(s)) for s in swings if s.size and np.isfinite(s).all()]
        zero = np.array(means[1:-1])  # a gait begins and ends with swings of their own
        if zero.size // 4 < _FEWEST_SWINGS:
            continue
        moved, sd = map(float, moved_between_ends(zero))
        if abs(moved) > max(ZERO_MOVES * weight_n, ZERO_SD * sd):
            yield Finding(
                "zero_moves", "warning", name,
                f"in the air it reads {abs(moved):.3g} N {'more' if moved > 0 else 'less'} at the "
                f"end than at the beginning of the walk, {100 * abs(moved) / weight_n:.2g} % of "
                "the weight",
                "let the cells warm up, or take zeros in every swing; a calibration that is "
                "tracked along the walk follows it, a constant one does not",
            )  # fmt: skip


def check_zeros_in_order(counts: FloatArray, names: Sequence[str]) -> list[Finding]:
    """Find a cell whose zeros go one way from one time without load to the next.

    By the t of their slope, ``t = r √((n − 2) / (1 − r²))``, Bonferroni over the cells, and by
    several times the range of the other cells' zeros.

    Parameters
    ----------
    counts
        Zero of each cell at each time, in their order, shape (n, c).
    """
    from footcal_cli.core import chances  # scipy, which not every log asks for

    n, cells = counts.shape
    good = np.isfinite(counts).all() and n > 2 and cells > 2
    if not good:
        return []
    moved = np.ptp(counts, axis=0)
    most = int(np.argmax(moved / max(float(np.median(moved)), 1e-300)))
    usual = float(np.median(np.delete(moved, most)))
    if not moved[most] > _APART * usual > 0.0:
        return []
    r = float(np.asarray(np.corrcoef(np.stack([np.arange(n), counts[:, most]])))[0, 1])
    t = abs(r) * np.sqrt((n - 2) / max(1.0 - r * r, 1e-12))
    if 2.0 * float(chances.t_sf(t, n - 2)) * cells > _BY_CHANCE:
        return []
    return [
        Finding(
            "zero_moves", "warning", names[most],
            f"its zero goes by {moved[most]:,.4g} counts from the first reading without load to "
            f"the last, those of the other cells by {usual:,.4g}",
            "let the cells warm up, or take zeros before each round and give each round its own",
        )
    ]  # fmt: skip


def _late(force: FloatArray, names: Sequence[str], step_s: float) -> Iterator[Finding]:
    """One foot's samples behind the other's: load then seems to vanish between the steps."""
    first, second = (force - force.mean(axis=0)).T
    if float(np.ptp(force, axis=0).min()) <= 0 or np.corrcoef(first, second)[0, 1] > 0.5:
        return
    most = min(round(LATEST_S / step_s), len(force) // 10)
    shifts = np.arange(-most, most + 1)
    core, width = first[most : len(force) - most], len(force) - 2 * most
    left = np.array([np.var(core + second[most + k : most + k + width]) for k in shifts])
    best = int(np.argmin(left))
    at_rest = left[most]
    walks = np.corrcoef(core, second[best : best + width])[0, 1] < -FOLLOWS
    if walks and left[best] < HALF * at_rest and abs(shifts[best]) * step_s > LATE_S:
        later = names[1] if shifts[best] > 0 else names[0]
        yield Finding(
            "foot_late", "alarm", later,
            f"its readings come {1e3 * abs(shifts[best]) * step_s:.0f} ms after the other foot's: "
            f"moved back, {100 * (1 - left[best] / at_rest):.0f} % less of the whole force changes",
            "stamp the readings of both feet where they are taken, by one clock",
        )  # fmt: skip


@listed
def check_gains_halfway(readings: FloatArray, names: Sequence[str]) -> Iterator[Finding]:
    """Compare each cell with its siblings in the first and the second half of a log.

    Parameters
    ----------
    readings
        Of the cells of one foot, shape (n, c).
    """
    some = readings[:: -(-len(readings) // _MOST_FITTED) or 1]
    good = some[np.isfinite(some).all(axis=1)]
    if len(good) < 2 * _FEWEST or len(names) < 3:
        return
    halves = np.array_split(good, 2)
    if min(float(np.ptp(half, axis=0).min()) for half in halves) <= 0:
        return  # a cell that stands still is another finding
    for i, name in enumerate(names):
        others = np.delete(np.arange(len(names)), i)
        design = [np.column_stack([np.ones(len(h)), h[:, others]]) for h in halves]
        size = np.abs(design[0]).max(axis=0)
        for half in design:
            half /= size
        solved = [
            np.linalg.lstsq(d, h[:, i], rcond=None)[0] for d, h in zip(design, halves, strict=True)
        ]
        # how far the cell moves for what its siblings show, by either half
        moved = [float(np.std(design[1] @ s)) for s in solved]
        fits = [
            float(np.corrcoef(d @ s, h[:, i])[0, 1])
            for d, s, h in zip(design, solved, halves, strict=True)
        ]
        if min(fits) > FOLLOWS and not 1 / LET_GO < moved[1] / moved[0] < LET_GO:
            yield Finding(
                "gain_changes", "warning", name,
                f"in the second half of the log it moves {moved[1] / moved[0]:.2f} times as much "
                "as in the first one for the same readings of its siblings",
                "check its glue, its screws and the gain of its converter",
            )  # fmt: skip


@listed
def check_hum(time_s: FloatArray, readings: FloatArray, names: Sequence[str]) -> Iterator[Finding]:
    """Find a line in the upper half of one channel's spectrum (Fisher 1929), and in no other's."""
    time_s, readings = time_s[:_MOST_HEARD], readings[:_MOST_HEARD]
    good = np.isfinite(readings).all(axis=1)
    steps = np.diff(time_s[good])
    if good.sum() < _FEWEST or not np.median(steps) > 0 or np.ptp(steps) > np.median(steps):
        return
    step = float(np.median(steps))
    values = readings if good.all() else readings[good]
    frequency = np.fft.rfftfreq(len(values), step)
    upper = frequency > frequency[-1] / 2
    window = np.hanning(len(values))
    # one after the other: of a long log a spectrum takes as much room as the channel
    power = np.column_stack([
        np.abs(np.fft.rfft((own - own.mean()) * window)[upper]) ** 2 for own in values.T
    ])  # fmt: skip
    scale = np.maximum(np.var(values, axis=0), 1e-300)
    for i, name in enumerate(names):
        whole = float(power[:, i].sum())
        at = int(np.argmax(power[:, i]))
        # a window spreads a line over three neighbours
        line = float(power[max(at - 1, 0) : at + 2, i].sum())
        if not whole > 0:
            continue
        bins = power.shape[0] / 3
        chance = bins * (1.0 - line / whole) ** (bins - 1)
        others = np.median(np.delete(power[at] / scale, i)) if len(names) > 1 else 0.0
        amplitude = 4.0 * np.sqrt(power[at, i]) / len(values)
        if (
            chance < HUM_BY_CHANCE
            and power[at, i] > HUM_ALONE * _next_line(power[:, i], at)
            and amplitude > HUM_SHARE * float(np.ptp(values[:, i]))
            and others < HUM_OTHERS * power[at, i] / scale[i]
        ):
            yield Finding(
                "hum", "warning", name,
                f"a line of {frequency[upper][at]:.4g} Hz of {amplitude:,.4g} counts, in no other "
                "channel",
                "check its shield and its ground; a mains frequency may appear folded down",
            )  # fmt: skip


def _next_line(power: FloatArray, at: int) -> float:
    """The largest power beside a line that a window spreads over its neighbours."""
    rest = np.delete(power, np.arange(max(at - 3, 0), min(at + 4, power.size)))
    return float(rest.max()) if rest.size else 0.0


@listed
def check_sides(
    share: FloatArray, height_m: FloatArray, across_m: FloatArray, names: Sequence[str]
) -> Iterator[Finding]:
    """Compare which foot carries with which foot is in the air, and which lies on the left.

    Parameters
    ----------
    share
        Of each foot in the whole force, zeros taken from the smallest reading, shape (n, 2).
    height_m
        Of each foot above its lowest place, shape (n, 2).
    across_m
        How far the first foot lies to the left of the second one, shape (n,).
    """
    crossed = float(np.nanmedian(across_m)) if np.isfinite(across_m).any() else 0.0
    if crossed < 0:
        yield Finding(
            "feet_exchanged", "alarm", " and ".join(f"{n} foot" for n in names),
            f"the {names[0]} foot lies {-1e3 * crossed:.0f} mm to the right of the {names[1]} one",
            "exchange the feet in the stream of the body, or turn its axes",
        )  # fmt: skip
        return
    carries = []
    for k in (0, 1):
        in_air = (height_m[:, k] > LIFTED_M) & (height_m[:, 1 - k] < LIFTED_M / 2)
        values = share[in_air & np.isfinite(share).all(axis=1), k]
        if values.size < 20:
            return
        carries.append(float(np.median(values)))
    if min(carries) > EXCHANGED_SHARE:
        yield Finding(
            "feet_exchanged", "alarm", " and ".join(names),
            f"each foot carries {100 * min(carries):.0f} % of the robot while it is in the air",
            "exchange the plugs, or the names in the recipe, of left and right",
        )  # fmt: skip

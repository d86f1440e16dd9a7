"""Raw channels of one foot beside their siblings: dead, loose or turned."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding, listed
from footcal_cli.core.readings import DEAD_SPAN
from footcal_cli.core.signals import stretches

MOVING = 20.0
"""Span over the scatter from sample to sample from which siblings are seen to move."""
UNLOADED = 0.1
"""A lifted foot's cells all lie within this share of their range, for this share of the time."""
LOOSE_SCATTER, LOOSE_SHARE = 10.0, 0.1
"""A channel that scatters from sample to sample by so many times its siblings' scatter, and by so
much of its own range, has a loose contact; a load never makes it jump at every sample."""
RUSTLING = 0.04
"""Span of noise alone, as a share of the siblings' span, that leaves no room for a load."""
COARSE = 2.0**16
"""Codes of a converter of 16 bits; those of 24 bits beside it move by 2⁸ times as many."""
LEAST_OF_COARSE, LEAST_CODES = 0.1 * 2.0**-8, 8.0
"""Share of its siblings' span, and codes, that a live channel of 16 bits among 24 has at least."""
FOLLOWS, STRANGE = 0.8, 0.3
"""Shares of a channel's variance that known loads explain: of one that feels them, and of one that
surely does not."""
LIVELY = 0.5
"""A live channel goes up and down at least half as much, for its span, as its siblings do."""
BEYOND_NOISE = 1.3
"""Noise comes as far in one sample as in many; what comes so much further in many moves."""
LOUD = 0.5
"""Steps from sample to sample as a share of the siblings' span in which a load may be hidden."""
_FEWEST_LOADED, _FEWEST_STEPS = 12, 4


@listed
def check_dead_channels(
    readings: FloatArray, names: Sequence[str], known: FloatArray | None = None
) -> Iterator[Finding]:
    """Find channels of one foot that stand still, or only rustle, while their siblings move.

    Parameters
    ----------
    readings
        Counts, shape (n, c); converters of 16 and of 24 bits may stand side by side.
    known
        Where weights are put here and there: what moves the channels, load and moments, shape
        (n, k). None: their siblings show it.
    """
    good = _whole_rows(readings)
    if len(good) < (50 if known is None else _FEWEST_LOADED) or len(names) < 3:
        return
    span, scatter = _span_and_scatter(good)
    if known is None:
        lively = _liveliness(good, span)
        strange, rustles = lively <= LIVELY, lively == 0.0
        follows = ~strange
    else:
        felt = _followed(good, known[np.isfinite(readings).all(axis=1)])
        strange, follows, rustles = felt < STRANGE, felt > FOLLOWS, np.zeros(len(names), bool)
    for i, name in enumerate(names):
        mates = np.delete(np.arange(len(names)), i)
        usual, usual_scatter = (float(np.median(x[mates])) for x in (span, scatter))
        if usual <= 0 or (known is None and usual <= MOVING * usual_scatter):
            continue
        dead = bool(strange[i])
        if span[i] < DEAD_SPAN * usual:
            within = np.abs(good[:, i]).max() < COARSE
            coarse = within and span[i] > max(LEAST_OF_COARSE * usual, LEAST_CODES)
            clear = known is not None or _noise(good, i) * usual < span[i] / DEAD_SPAN
            dead = not (coarse and clear and follows[i])
        elif rustles[i] and span[i] < RUSTLING * usual:
            dead = True  # a load within the noise would be next to nothing of the others'
        elif known is None:  # a finer converter than its siblings'; what is louder may hide a load
            dead = dead and scatter[i] < LOUD * usual and _noise(good, i) > LOOSE_SCATTER
        if dead:
            yield Finding(
                "dead_cell", "alarm", name,
                f"the channel moves by {_plain(span[i])} while the others of its foot move by "
                f"{_plain(usual)}",
                "check its wires, its plug and that it carries the plate",
            )  # fmt: skip


def _followed(good: FloatArray, known: FloatArray) -> FloatArray:
    """Share of the variance of each channel, (c,), that known loads (n, k) explain, adjusted."""
    x, y = known - known.mean(axis=0), good - good.mean(axis=0)
    rest = y - x @ np.linalg.lstsq(x, y, rcond=1e-9)[0]
    n, k = x.shape
    total = np.maximum((y**2).sum(axis=0), np.finfo(float).tiny)
    return np.asarray(1.0 - (rest**2).sum(axis=0) / total * (n - 1) / (n - k - 1))


def _noise(good: FloatArray, i: int) -> float:
    """How far a channel steps while the foot rests, in the usual steps of its siblings.

    Steps of one code are those of the converter.
    """
    steps = np.array([max(float(np.percentile(np.abs(np.diff(x)), 25)), 1.0) for x in good.T])
    return float(steps[i] / np.median(np.delete(steps, i))) if steps[i] > 1.0 else 0.0


def _liveliness(good: FloatArray, span: FloatArray) -> FloatArray:
    """How much each channel goes up and down for what the others do, (c,); 0 of noise alone.

    Noise comes no further in many samples than in one, drift in few only their share of it.
    """
    near, lag = _steps(good, 1), 1
    ways = np.zeros(near.size)
    while np.median(ways) < 0.2 and 8 * lag < len(good):
        lag *= 2
        far = _steps(good, lag)
        moves = (far > BEYOND_NOISE * near) & (span > 0)
        ways = np.where(moves, far / np.where(span > 0, span, 1.0), 0.0)
    others = [float(np.median(np.delete(ways, i))) for i in range(ways.size)]
    return np.array(
        [way / other if other > 0.0 else np.inf for way, other in zip(ways, others, strict=True)]
    )


def _steps(good: FloatArray, lag: int) -> FloatArray:
    """How far each channel comes in so many samples, the upper quartile, shape (c,)."""
    return np.array([np.percentile(np.abs(x[lag:] - x[:-lag]), 75) for x in good.T])


def _plain(value: float) -> str:
    """A span without a power of ten: 0.04, 516,412."""
    return f"{value:,.0f}" if value >= 1e3 else f"{value:.4g}"


def check_loose_channels(readings: FloatArray, names: Sequence[str]) -> list[Finding]:
    """Find channels of one foot that jump at every sample while their siblings do not.

    Parameters
    ----------
    readings
        In units that siblings share, shape (n, c).
    """
    good = _whole_rows(readings)
    if len(good) < 50 or len(names) < 3:
        return []
    span, scatter = _span_and_scatter(good)
    usual = np.array([np.median(np.delete(scatter, i)) for i in range(len(names))])
    loose = (scatter > LOOSE_SCATTER * usual) & (scatter > LOOSE_SHARE * span) & (usual > 0)
    return [
        Finding(
            "loose_channel", "warning", name,
            f"the channel jumps by {s:,.4g} from sample to sample, the others of its foot by "
            f"{u:,.4g}",
            "check its plug, its shield and its supply",
        )
        for name, s, u in zip(
            np.array(names)[loose].tolist(), scatter[loose], usual[loose], strict=True
        )
    ]  # fmt: skip


def _whole_rows(readings: FloatArray) -> FloatArray:
    """Rows without a lost sample; no copy where none is lost."""
    whole = np.ones(len(readings), dtype=bool)
    for column in readings.T:
        whole &= np.isfinite(column)
    return readings if whole.all() else readings[whole]


def _span_and_scatter(good: FloatArray) -> tuple[FloatArray, FloatArray]:
    """From the 2nd to the 98th percentile, and the usual step, of each channel, (c,) each.

    Channel by channel: what is made of all channels of a long log at once is as large as it is.
    """
    span = [np.subtract(*np.percentile(column, [98, 2])) for column in good.T]
    scatter = [np.median(np.abs(np.diff(column))) for column in good.T]
    return np.array(span), np.array(scatter)


def check_turned_channels(readings: FloatArray, names: Sequence[str]) -> list[Finding]:
    """Find a channel of one foot that falls while all its siblings rise with the load.

    Whatever the sign of the bridges, a foot that is put down moves all of them the same way.

    Parameters
    ----------
    readings
        Shape (n, c); of a foot that is put down and lifted.
    """
    good = _whole_rows(readings)
    if len(good) < 50 or len(names) < 4:
        return []
    low, high = np.array([np.percentile(column, [2, 98]) for column in good.T]).T
    share = good - low
    share /= np.where(high > low, high - low, 1.0)
    steps = np.empty(len(names))
    for i in range(len(names)):
        others = np.zeros(len(share))
        for mate in np.delete(np.arange(len(names)), i):
            others += share[:, mate]
        others /= len(names) - 1
        down, up = others >= np.percentile(others, 70), others <= np.percentile(others, 30)
        steps[i] = np.median(share[down, i]) - np.median(share[up, i])
    turned = np.flatnonzero(steps < -0.2)
    rest = np.delete(steps, turned)
    if turned.size != 1 or rest.min() < 0.2:
        return []
    mates = np.delete(share, turned, axis=1)
    in_the_air = [(mates < UNLOADED).all(axis=1), (mates > 1.0 - UNLOADED).all(axis=1)]
    lifted = max(in_the_air, key=lambda flags: int(flags.sum()))
    if lifted.mean() < UNLOADED or len(stretches(lifted)) < _FEWEST_STEPS:
        return []  # standing, heel and toes take turns
    name = names[int(turned[0])]
    return [
        Finding(
            "turned_sign", "alarm", name,
            "the channel moves against all the others of its foot when the foot is put down",
            "check the sign of its scale and the wires of its bridge",
        )
    ]  # fmt: skip

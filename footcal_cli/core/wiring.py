"""Cells whose readings are exchanged, copied or frozen, by what loads and steps do to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.quality import Finding
from footcal_cli.core.readings import DEAD_SPAN

MUCH_BETTER = 0.25
"""RMS error after exchanging two channels over that before, below which they are exchanged."""
CLEARLY = 0.5
"""And below this share of the next best exchange."""
BETTER_WALKING, WRONGLY = 0.85, 0.01
"""The same while walking, and the probability of an alarm on cells that are not exchanged: of all
pairs in five walks the ratio is 0.2 to 0.73 where two cells are exchanged, 1.37 and more where not,
as long as the demanded CoP moves slowly."""
BLOCKS = 12
WINDOW_S = 3.0
"""Length of a walk over which the steps of two cells are compared."""
TWIN = 0.08
"""Share of a cell's own spread that another cell leaves unexplained, below which both are one:
0.01 to 0.03 of copied channels, 0.2 and more of any other two."""
SILENT, MOVING = 0.1, 0.3
"""Shares of the usual spread below which a cell stands still, and above which it moves."""
CARRIED = 0.15
"""Share of a foot's load that it carries while it moves where its readings are another's: 0.3 to
0.5, and less than 0.05 where they are its own."""
_RESTING = 0.05
_FEWEST_WINDOWS = 5
_FEWEST_ROWS = 20


def check_exchanged_cells(
    counts: FloatArray,
    names: Sequence[str],
    cell_m: FloatArray,
    hole_m: FloatArray,
    load_n: FloatArray,
) -> list[Finding]:
    """Fit scale and bias of all cells to placements, in the given order and with pairs exchanged.

    ``Σ (c_i S_i + d_i) = W`` and ``Σ (p_i − h)(c_i S_i + d_i) = 0`` ([NAO], eqs. (1)–(5), (8)).

    Parameters
    ----------
    counts
        Readings, shape (n, c).
    cell_m, hole_m
        Where cells and weights are, foot frame, shapes (c, 2) and (n, 2).
    load_n
        Weights, shape (n,).
    """
    arms = cell_m[None] - hole_m[:, None]
    lever = float(np.abs(cell_m - cell_m.mean(axis=0)).max())
    return _exchanged(counts, names, arms / lever, load_n)


def check_exchanged_walking(
    readings: FloatArray, names: Sequence[str], arms_m: FloatArray, demanded_n: FloatArray
) -> list[Finding]:
    """The same for walking or standing: forces balance what the motion demands, about its CoP.

    [NAO], eqs. (9)–(11). A calibration that drifts leaves more of an error than weights do.

    Parameters
    ----------
    readings
        Of all cells, shape (n, c).
    arms_m
        From the demanded CoP to each cell, in the world, shape (n, c, 2).
    demanded_n
        Vertical force, shape (n,).
    """
    from footcal_cli.core import chances

    count, arms = len(names), arms_m / float(np.abs(arms_m).mean())
    span = np.ptp(readings, axis=0)
    # without a dead cell nothing balances, and an exchange may stand in for it
    if len(demanded_n) < BLOCKS + 4 * count or span.min() < DEAD_SPAN * np.median(span):
        return []
    given = _left_out(readings, arms, demanded_n)
    if not given.min() > 0:
        return []
    tried = []
    for a, b in combinations(range(count), 2):
        other = _left_out(readings[:, _exchange(count, a, b)], arms, demanded_n)
        tried.append((float(np.sqrt(other.sum() / given.sum())), other, names[a], names[b]))
    ratio, best, first, second = min(tried, key=lambda one: one[0])
    gain = np.log(given / np.maximum(best, 1e-300))
    chance = chances.t_sf(gain.mean() / (gain.std(ddof=1) / np.sqrt(BLOCKS)), BLOCKS - 1)
    if ratio > BETTER_WALKING or chance * len(tried) > WRONGLY:
        return []
    return [_exchanged_finding(first, second, ratio)]


def check_balanced(
    forces_n: FloatArray, names: Sequence[str], arms_m: FloatArray, demanded_n: FloatArray
) -> list[Finding]:
    """A cell of reversed sign, else two that are exchanged."""
    turned = check_turned_balanced(forces_n, names, arms_m, demanded_n)
    return turned or check_exchanged_walking(forces_n, names, arms_m, demanded_n)


def check_turned_balanced(
    forces_n: FloatArray, names: Sequence[str], arms_m: FloatArray, demanded_n: FloatArray
) -> list[Finding]:
    """Find a cell whose sign is turned: with it turned back the forces balance, zeros free.

    A foot need not be lifted for that, as long as the load moves.

    Parameters
    ----------
    forces_n
        By the calibration to start from, shape (n, c).
    arms_m, demanded_n
        As for `check_exchanged_walking`.
    """
    count, arms = len(names), arms_m / float(np.abs(arms_m).mean())
    if len(demanded_n) < BLOCKS + 4 * count:
        return []
    design, target = _balance(forces_n, arms, demanded_n)
    zeros, sides = design[:, count:], np.column_stack([target, design[:, :count]])
    sides = sides - zeros @ np.linalg.lstsq(zeros, sides, rcond=1e-9)[0]

    def left(signs: FloatArray) -> float:
        return float(np.sqrt(np.mean((sides[:, 0] - sides[:, 1:] @ signs) ** 2)))

    given = left(np.ones(count))
    tried = sorted((left(np.where(np.arange(count) == k, -1.0, 1.0)), k) for k in range(count))
    (best, at), others = tried[0], tried[1:]
    if best > MUCH_BETTER * given or (others and best > CLEARLY * others[0][0]):
        return []
    return [
        Finding(
            "turned_sign", "alarm", names[at],
            "the channel reads less where it carries more: with its sign reversed the error of the "
            f"balance falls to {100 * best / given:.0f} %",
            "check the sign of its scale and the wires of its bridge",
        )
    ]  # fmt: skip


def _left_out(readings: FloatArray, arms: FloatArray, load_n: FloatArray) -> FloatArray:
    """Squared error of the balance in each block of rows by the fit of all others, (`BLOCKS`,)."""
    design, target = _balance(readings, arms, load_n)
    table = np.column_stack([design, target]).reshape(3, len(load_n), -1)
    size = np.sqrt(np.mean(table**2, axis=(0, 1)))
    table /= np.where(size > 0, size, 1.0)
    # the triangle of a block's rows has the same least squares as the rows themselves
    parts = [
        np.asarray(np.linalg.qr(part.reshape(-1, table.shape[2]), mode="r"))
        for part in np.array_split(table.swapaxes(0, 1), BLOCKS)
    ]
    found = np.empty(BLOCKS)
    for k, part in enumerate(parts):
        others = np.vstack([*parts[:k], *parts[k + 1 :]])
        fitted = np.linalg.lstsq(others[:, :-1], others[:, -1], rcond=1e-9)[0]
        found[k] = np.sum((part[:, -1] - part[:, :-1] @ fitted) ** 2)
    return found


def _exchange(count: int, a: int, b: int) -> IntArray:
    """The order of `count` channels with two exchanged."""
    order = np.arange(count)
    order[[a, b]] = b, a
    return order


def _exchanged(
    counts: FloatArray, names: Sequence[str], arms: FloatArray, load_n: FloatArray
) -> list[Finding]:
    count = len(names)
    if len(load_n) < 2 * count + 2:
        return []
    given = _misfit(counts, arms, load_n)
    if not given > 0:
        return []
    tried = []
    for a, b in combinations(range(count), 2):
        other = _misfit(counts[:, _exchange(count, a, b)], arms, load_n)
        tried.append((other, names[a], names[b]))
    tried.sort()
    best, first, second = tried[0]
    if best > MUCH_BETTER * given or (len(tried) > 1 and best > CLEARLY * tried[1][0]):
        return []
    return [_exchanged_finding(first, second, best / given)]


def check_exchanged_feet(
    load_n: FloatArray, speed_mps: FloatArray, names: Sequence[str]
) -> list[Finding]:
    """A foot that moves over the ground carries nothing: two that carry each other's load.

    Parameters
    ----------
    load_n, speed_mps
        Vertical force of each foot, of any zero, and its speed along the floor, shape (n, feet).
    names
        Of the feet.
    """
    good = np.isfinite(load_n).all(axis=1) & np.isfinite(speed_mps).all(axis=1)
    if good.sum() < _FEWEST_ROWS:
        return []
    load, speed = load_n[good], speed_mps[good]
    load = np.maximum(load - np.quantile(load, _RESTING, axis=0), 0.0)
    moves = speed > 0.5 * np.quantile(speed, 1.0 - _RESTING, axis=0)
    # share of the load of foot i while foot j moves
    share = load.T @ moves / np.maximum(load.sum(axis=0), 1e-300)[:, None]
    tried = [
        ((share[i, j] + share[j, i]) / (share[i, i] + share[j, j]), names[i], names[j])
        for i, j in combinations(range(len(names)), 2) if share[i, i] + share[j, j] > 2 * CARRIED
    ]  # fmt: skip
    if not tried or min(tried)[0] > MUCH_BETTER:
        return []
    ratio, first, second = min(tried)
    return [
        Finding(
            "exchanged_channels", "alarm", f"{first}, {second}",
            f"{first} and {second} carry load while they move, and with their names exchanged "
            f"{100 * ratio:.0f} % of it: their readings look exchanged",
            "lift one foot by hand; exchange the plugs or the names in the recipe",
        )
    ]  # fmt: skip


def _exchanged_finding(first: str, second: str, ratio: float) -> Finding:
    return Finding(
        "exchanged_channels", "alarm", f"{first}, {second}",
        f"the readings of {first} and {second} look exchanged: with their names exchanged the "
        f"error of the balance falls to {100 * ratio:.0f} %",
        "press one of the two cells by hand; exchange the plugs or the names in the recipe",
    )  # fmt: skip


def _misfit(counts: FloatArray, arms: FloatArray, load_n: FloatArray) -> float:
    """RMS error of force and moments, the latter over a lever, in N.

    Parameters
    ----------
    arms
        Of each cell, over the lever, shape (n, c, 2).
    """
    design, target = _balance(counts, arms, load_n)
    norm = np.sqrt(np.mean(design**2, axis=0))
    norm = np.where(norm > 0, norm, 1.0)
    fitted = np.linalg.lstsq(design / norm, target, rcond=1e-9)[0]
    return float(np.sqrt(np.mean((target - design / norm @ fitted) ** 2)))


def _balance(
    counts: FloatArray, arms: FloatArray, load_n: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Force, then both moments, by scales and zeros: design (3 n, 2 c) and what they must be."""
    readings = np.hstack([counts - counts.mean(axis=0), np.ones_like(counts)])
    parts = [readings * np.tile(arms[:, :, k], (1, 2)) for k in range(2)]
    design = np.vstack([readings, *parts])
    target = np.concatenate([load_n, np.zeros(2 * len(load_n))])
    return design, target


def check_channels_walking(
    time_s: FloatArray, forces: FloatArray, names: Sequence[str]
) -> list[Finding]:
    """Find cells of a walk that show another cell's load, or none for a while.

    Noise and drift of their own hide neither from a comparison of what the steps do to them.

    Parameters
    ----------
    time_s, forces
        Unfiltered, shape (n,) and (n, c).
    """
    windows = [
        rows for rows in _windows(time_s) if rows.size >= _FEWEST_ROWS
        and np.isfinite(forces[rows]).all()
    ]  # fmt: skip
    if len(windows) < _FEWEST_WINDOWS or len(names) < 3:
        return []
    moved = [forces[rows] - forces[rows].mean(axis=0) for rows in windows]
    return [*_silent(np.array([m.std(axis=0) for m in moved]), names), *_twins(moved, names)]


def _windows(time_s: FloatArray) -> list[IntArray]:
    number = np.floor((time_s - time_s[0]) / WINDOW_S).astype(np.int64)
    return np.split(np.arange(time_s.size), np.flatnonzero(np.diff(number)) + 1)


def _silent(spread: FloatArray, names: Sequence[str]) -> Iterator[Finding]:
    """Channels that moved with the steps once and no longer do while the others go on."""
    usual = np.median(spread, axis=0)
    usual = np.where(usual > SILENT * np.median(usual), usual, np.median(usual))
    share = spread / np.maximum(usual, 1e-300)
    for i, name in enumerate(names):
        others = np.median(np.delete(share, i, axis=1), axis=1)
        silent = (share[:, i] < SILENT) & (others > MOVING)
        if silent.sum() >= 2 and (share[:, i] > MOVING).any():
            yield Finding(
                "stuck_channel", "alarm", name,
                f"the reading of {name} stands still for about {silent.sum() * WINDOW_S:.0f} s "
                "while the other cells follow the steps",
                "check that the channel is connected and that its reading is refreshed",
            )  # fmt: skip


def _twins(moved: Sequence[FloatArray], names: Sequence[str]) -> list[Finding]:
    """Channels that are another one but for gain and offset, as no other two nearly are.

    Of loads that turn each other over none is a copy: cells in the middle of two feet share a
    weight.
    """
    inner = np.array([m.T @ m for m in moved])
    own = np.einsum("wii->wi", inner)
    left = {}
    for a, b in combinations(range(len(names)), 2):
        same = np.maximum(inner[:, a, b], 0.0)
        rest = own[:, a] - same**2 / np.maximum(own[:, b], 1e-300)
        left[a, b] = float(np.sqrt(max(rest.sum(), 0.0) / max(own[:, a].sum(), 1e-300)))
    (a, b), least = min(left.items(), key=lambda item: item[1])
    rest = [value for pair, value in left.items() if pair != (a, b)]
    if least > TWIN or least > CLEARLY * min(rest):
        return []
    return [
        Finding(
            "duplicate_channel", "alarm", f"{names[a]}, {names[b]}",
            f"{names[a]} and {names[b]} show the same load: a gain and an offset explain all but "
            f"{least:.1%} of one by the other (any other two cells: {min(rest):.0%} or more)",
            "check the channel map of the logger; one of the cells is not recorded",
        )
    ]  # fmt: skip

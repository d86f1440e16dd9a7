"""Weights on a foot: whether holes, weights and the cells' places agree, before any calibration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from footcal_cli.core.checks.lines import moved_between_ends
from footcal_cli.core.parameters import FloatArray, IntArray
from footcal_cli.core.plausibility import check_shares
from footcal_cli.core.quality import Finding, listed

LARGE_M, LARGE_LOAD = 0.012, 0.15
"""An error of a hole or a weight that no cell makes: cells under a plate err by a few millimetres
and a few per cent."""
UNUSUAL = 6.0
"""And so many times that of the usual placement."""
SHIFT_M = 0.025
"""By so much holes and cells may be measured from different points."""
EXCHANGED = 0.8
"""Squared misfit with two holes taken for each other, as a share of that as given and of that with
the next best two: no curve of a cell depends on which hole is which."""
MUCH_BETTER, WRONG = 0.3, 0.15
"""Misfit of the balance with holes read otherwise, as a share of that as given; least misfit."""
_MOVED, _MOVED_SD, _PAIR = 0.02, 5.0, 2
"""Share of the weight, and sd of chance, by which a zero has moved from one empty plate to another;
of a pair nothing says how far chance goes."""
_FEWEST = 5
_MOST_WRONG = 1 / 3
_READ_OTHERWISE = {
    "x and y exchanged": np.array([[0.0, 1.0], [1.0, 0.0]]),
    "mirrored left for right": np.diag([1.0, -1.0]),
    "mirrored front to back": np.diag([-1.0, 1.0]),
    "turned by half a turn": np.diag([-1.0, -1.0]),
}


@listed
def check_holes(
    foot: str,
    placement: tuple[str, ...],
    own: IntArray,
    counts: FloatArray,
    hole_m: FloatArray,
    load_n: FloatArray,
    cell_m: FloatArray,
) -> Iterator[Finding]:
    """Fit ``S_i = a_i + W (b_i + c_i · h)``; a placement that does not follow is wrong.

    Each cell takes a share of the weight that is linear in the hole h, as under any rigid plate.

    Parameters
    ----------
    placement, own
        Names, and the number of each row's, shape (n,).
    counts, hole_m, load_n
        Shapes (n, c), (n, 2), (n,).
    cell_m
        Places of the cells, shape (c, 2).
    """
    kept = np.ones(len(own), dtype=bool)
    found: list[Finding] = []
    pair = _exchanged(own, counts, hole_m, load_n)
    if pair is not None:
        one, other = pair
        yield Finding(
            "holes_exchanged", "warning", f"{foot} {placement[one]}, {placement[other]}",
            "with the holes of these two exchanged all placements agree",
            "check which hole each of them was, and exchange them in the log",
        )  # fmt: skip
        hole_m = _with_exchanged(own, hole_m, pair)
    several = len(placement)
    while several >= _FEWEST and len(found) <= _MOST_WRONG * several:
        errors = _errors_left_out(own, kept, counts, hole_m, load_n)
        if errors is None:
            break
        numbers, moved, lighter = errors
        share = np.maximum(moved / LARGE_M, np.abs(lighter) / LARGE_LOAD)
        worst = int(np.argmax(share))
        if share[worst] < 1.0 or share[worst] < UNUSUAL * float(np.median(share)):
            break
        found.append(_finding(foot, placement[numbers[worst]], moved[worst], lighter[worst]))
        kept &= own != numbers[worst]
    if len(found) <= _MOST_WRONG * several:
        yield from found
    yield from _whole_plate(foot, _shares(counts[kept], hole_m[kept], load_n[kept]), cell_m)


def _finding(foot: str, name: str, moved_m: float, lighter: float) -> Finding:
    how = "heavier" if lighter > 0 else "lighter"
    return Finding(
        "placement_off", "warning", f"{foot} {name}",
        f"by all other placements its weight lay {1e3 * moved_m:.0f} mm away from the hole that "
        f"the log gives and was {100 * abs(lighter):.0f} % {how}",
        "check the hole and the weight that were written down, and that all cells carried",
    )  # fmt: skip


def _exchanged(
    own: IntArray, counts: FloatArray, hole_m: FloatArray, load_n: FloatArray
) -> tuple[int, int] | None:
    """Two placements whose holes, taken for each other, leave far less than as given."""
    numbers = np.unique(own)
    if numbers.size < _FEWEST:
        return None

    def left(hole: FloatArray) -> float:
        residual = counts - _design(hole, load_n) @ _shares(counts, hole, load_n)
        return float(np.sum(residual**2))

    pairs = [(int(a), int(b)) for a, b in combinations(numbers, 2)]
    tried = [left(_with_exchanged(own, hole_m, pair)) for pair in pairs]
    best, second = np.argsort(tried)[:2]
    least = EXCHANGED * min(left(hole_m), tried[second])
    return pairs[best] if tried[best] < least else None


def _with_exchanged(own: IntArray, hole_m: FloatArray, pair: tuple[int, int]) -> FloatArray:
    """Holes with those of two placements taken for each other."""
    one, other = (own == number for number in pair)
    changed = hole_m.copy()
    changed[one], changed[other] = hole_m[other][0], hole_m[one][0]
    return changed


def _design(hole_m: FloatArray, load_n: FloatArray) -> FloatArray:
    return np.column_stack([np.ones(len(load_n)), load_n, load_n[:, None] * hole_m])


def _shares(counts: FloatArray, hole_m: FloatArray, load_n: FloatArray) -> FloatArray:
    """a, b, c of every cell, shape (4, c)."""
    design = _design(hole_m, load_n)
    size = np.abs(design).max(axis=0)
    solved: FloatArray = np.linalg.lstsq(design / size, counts, rcond=None)[0] / size[:, None]
    return solved


def _errors_left_out(
    own: IntArray, kept: np.ndarray, counts: FloatArray, hole_m: FloatArray, load_n: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray] | None:
    """Each placement by the fit of all others: distance of its weight and relative error, (k,)."""
    numbers = np.unique(own[kept])
    moved, lighter = np.zeros(numbers.size), np.zeros(numbers.size)
    for i, number in enumerate(numbers):
        rest, mine = kept & (own != number), own == number
        design = _design(hole_m[rest], load_n[rest])
        if np.linalg.matrix_rank(design / np.abs(design).max(axis=0)) < 4:
            return None
        solved = _shares(counts[rest], hole_m[rest], load_n[rest])
        # the weight and its moment that explain the readings, against what was written down
        left = (counts[mine] - solved[0]).ravel()
        load = load_n[mine]
        effect = np.concatenate([w * solved[1:].T for w in load])
        units = np.abs(effect).max(axis=0)
        weight, x, y = np.linalg.lstsq(effect / units, left, rcond=None)[0] / units
        if not weight > 0.05:
            moved[i], lighter[i] = 0.0, weight - 1.0
            continue
        moved[i] = float(np.hypot(*(np.array([x, y]) / weight - hole_m[mine][0])))
        lighter[i] = weight - 1.0
    return numbers, moved, lighter


def _whole_plate(foot: str, shares: FloatArray, cell_m: FloatArray) -> Iterator[Finding]:
    """All holes read otherwise, or measured from another point, by the balance with the cells.

    ``Σ s_i (b_i + c_i · h) = 1`` and ``Σ p_i s_i (b_i + c_i · h) = h`` for all h.
    """
    lever = float(np.abs(cell_m - cell_m.mean(axis=0)).max())
    if not lever > 0:
        return
    given, shift = _misfit(shares, cell_m, lever, np.eye(2))
    others = {how: _misfit(shares, cell_m, lever, turn)[0] for how, turn in _READ_OTHERWISE.items()}
    best = min(others, key=others.__getitem__)
    if given > WRONG and others[best] < MUCH_BETTER * given:
        yield Finding(
            "holes_read_wrongly", "alarm", f"{foot} holes",
            f"the cells' places and the holes disagree; with holes {best} they agree "
            f"({100 * others[best]:.0f} % instead of {100 * given:.0f} % misfit)",
            "check which way x and y of the holes point, and which cell has which plug",
        )  # fmt: skip
    elif given < WRONG and float(np.hypot(*shift)) > SHIFT_M:
        yield Finding(
            "holes_shifted", "warning", f"{foot} holes",
            f"by the cells' places all holes lie {1e3 * shift[0]:.0f} mm further forward and "
            f"{1e3 * shift[1]:.0f} mm further left than written down",
            "measure holes and cells from the same point of the foot",
        )  # fmt: skip


def _misfit(
    shares: FloatArray, cell_m: FloatArray, lever: float, turn: FloatArray
) -> tuple[float, FloatArray]:
    """Misfit of the balance, and how much further out all holes lie (m), shape (2,)."""
    gain, slope = shares[1], lever * (turn @ shares[2:])
    arm = cell_m / lever
    size = float(np.abs(np.vstack([gain, slope])).max())
    # unknown: the scales s_i, and the shift t of the holes
    rows, right = [], []

    def equation(of_cells: FloatArray, of_shift: tuple[float, float], value: float) -> None:
        rows.append([*(of_cells / size), *of_shift])
        right.append(value)

    equation(gain, (0.0, 0.0), 1.0)
    for k in (0, 1):
        equation(slope[k], (0.0, 0.0), 0.0)
        equation(arm[:, k] * gain, (-1.0, 0.0) if k == 0 else (0.0, -1.0), 0.0)
        for j in (0, 1):
            equation(arm[:, k] * slope[j], (0.0, 0.0), float(k == j))
    matrix, target = np.array(rows), np.array(right)
    solved = np.linalg.lstsq(matrix, target, rcond=None)[0]
    left = matrix @ solved - target
    return float(np.sqrt((left @ left) / (target @ target))), lever * solved[-2:]


def check_placed(forces_n: FloatArray, cells: Sequence[str], load_n: FloatArray) -> list[Finding]:
    """What known weights on a foot say of its calibrated cells (`check_shares`) and their zeros.

    Parameters
    ----------
    forces_n, load_n
        In the order they were taken, shape (n, c) and (n,).
    """
    found = check_shares(forces_n, cells, load_n, calibrated=True)
    return [*found, *_moved_zeros(forces_n[load_n == 0.0], cells, load_n)]


@listed
def _moved_zeros(
    empty_n: FloatArray, cells: Sequence[str], load_n: FloatArray
) -> Iterator[Finding]:
    """Zeros of the first and the last empty plate, shape (k, c), that differ by more than chance.

    Chance is how far one differs from the next; two alone have the share of the weight to pass.
    """
    if len(empty_n) < 2 or not len(cells) or not np.isfinite(empty_n).all():
        return
    weight = float(np.nanmedian(np.abs(load_n[load_n != 0.0])))
    moved, chance = moved_between_ends(empty_n)
    most = int(np.argmax(np.abs(moved)))
    if len(empty_n) > _PAIR and abs(moved[most]) < _MOVED_SD * chance[most]:
        return
    if abs(moved[most]) > _MOVED * weight:
        yield Finding(
            "zero_moves", "warning", cells[most],
            f"without a load it reads {abs(moved[most]):.2g} N "
            f"{'more' if moved[most] > 0 else 'less'} at the end than at the beginning, "
            f"{100 * abs(moved[most]) / weight:.2g} % of the weight",
            "let the cells warm up, and read the empty plate before each round; scales and places "
            "of cells hold no better than their zeros",
        )  # fmt: skip

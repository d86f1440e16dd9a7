"""A small world with hidden effects: one foot, four cells, trials of known content.

Outputs are total load and its two moments against a perfect reference, the calibration is a scale
and a bias per cell. Noise is autocorrelated and every trial has its own gain and offset. It shares
no code with the package but the arrays of `Problem`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.parameters import FloatArray

RATE_HZ = 20.0
TRIAL_S = 20.0
ROWS = int(RATE_HZ * TRIAL_S)
CELL_X_M = np.array([0.07, 0.07, -0.05, -0.05])
CELL_Y_M = np.array([0.03, -0.03, 0.03, -0.03])
OUTPUTS = ("fz", "mx", "my")
SCALES = np.array([1.0, 0.04, 0.06])
NOISES = ("white", "ar9", "ar98", "heteroscedastic", "gain_offset")


@dataclass(frozen=True)
class World:
    """Loads of all trials, shape (B, n, 4), and what else was recorded."""

    cells: FloatArray
    shear: FloatArray
    temperature: FloatArray
    time_s: FloatArray


def make_world(rng: np.random.Generator, trials: int = 12, taps: bool = False) -> World:
    """Sway, steps, ramps, holds and unloaded stretches with random phases in every trial."""
    time = np.arange(ROWS) / RATE_HZ
    cells, shear = [], []
    for _ in range(trials):
        shape = rng.uniform(0, 2 * np.pi, 8)
        steps = np.repeat(rng.choice([0.15, 0.5, 1.0, 1.3], 10), ROWS // 10)
        steps = lfilter([0.35], [1, -0.65], steps) if not taps else steps
        load = 18 * steps * (1 + 0.15 * np.sin(2 * np.pi * 0.9 * time + shape[0]))
        load = np.maximum(load + 2 * np.sin(2 * np.pi * 0.23 * time + shape[1]), 0.0)
        x = 0.025 * np.sin(2 * np.pi * 0.31 * time + shape[2]) + 0.012 * np.sin(
            2 * np.pi * 0.83 * time + shape[3]
        )
        y = 0.014 * np.sin(2 * np.pi * 0.43 * time + shape[4]) + 0.006 * np.sin(
            2 * np.pi * 1.1 * time + shape[5]
        )
        a, b = (x + 0.05) / 0.12, (y + 0.03) / 0.06
        share = np.stack([a * b, a * (1 - b), (1 - a) * b, (1 - a) * (1 - b)], axis=1)
        cells.append(load[:, None] * share)
        shear.append(0.1 * load * np.sin(2 * np.pi * 0.37 * time + shape[6]))
    start = np.arange(trials) * 60.0
    temperature = 24 + 3 * rng.standard_normal(trials)[:, None] + 0.01 * time
    return World(np.array(cells), np.array(shear), temperature, start[:, None] + time)


def outputs_of(cells: FloatArray) -> FloatArray:
    """Total and moments of cell forces (..., 4), shape (..., 3), in comparable units."""
    parts = [cells.sum(-1), (cells * CELL_Y_M).sum(-1), (cells * CELL_X_M).sum(-1)]
    return np.asarray(np.stack(parts, axis=-1) / SCALES)


def _play(x: FloatArray, width: float) -> FloatArray:
    z = np.zeros_like(x)
    state = np.zeros((x.shape[0], x.shape[2]))
    for t in range(x.shape[1]):
        state = np.clip(state, x[:, t] - width, x[:, t] + width)
        z[:, t] = state
    return z - x


def _late(x: FloatArray, seconds: float) -> FloatArray:
    grid = np.arange(x.shape[1]) / RATE_HZ
    return np.stack(
        [
            np.stack([np.interp(grid - seconds, grid, trial[:, i]) for i in range(x.shape[2])], 1)
            for trial in x
        ]
    )


def _slow(x: FloatArray, seconds: float) -> FloatArray:
    keep = np.exp(-1.0 / (RATE_HZ * seconds))
    return np.asarray(lfilter([1 - keep], [1, -keep], x, axis=1, zi=keep * x[:, :1])[0])


def library_effects(
    world: World,
) -> dict[str, list[tuple[tuple[tuple[str, float], ...], FloatArray]]]:
    """Sixteen effects of the cells' readings, each with its shapes: changes (B, n, 3)."""
    x = world.cells
    total = x.sum(-1, keepdims=True)
    warm = (world.temperature - 24.0)[..., None]
    trial_time = (world.time_s - world.time_s[:, :1])[..., None]
    session = (world.time_s / world.time_s.max())[..., None]
    ones = np.ones_like(x)
    cop = outputs_of(x)

    def both(change: FloatArray) -> list[tuple[tuple[tuple[str, float], ...], FloatArray]]:
        return [((), outputs_of(change))]

    compliance = np.zeros_like(cop)
    compliance[..., 2] = total[..., 0] ** 2 / SCALES[2] * 1e-3
    shear = np.zeros_like(cop)
    shear[..., 0] = world.shear
    tilt = np.zeros_like(cop)
    tilt[..., 1] = world.shear / SCALES[1] * 0.05
    return {
        "quadratic": both(x**2 / 10),
        "cubic": both(x**3 / 100),
        "hinge": [((("load", h),), outputs_of(np.maximum(x - h, 0))) for h in (3.0, 6.0, 9.0)],
        "hysteresis": [((("width", w),), outputs_of(_play(x, w))) for w in (0.3, 0.8, 2.0)],
        "creep": [((("tau", s),), outputs_of(_slow(x, s))) for s in (3.0, 8.0)],
        "lag": both(_slow(x, 0.05) - x),
        "delay": both(_late(x, 0.02) - x),
        "crosstalk": both(np.roll(x, 1, axis=-1)),
        "bypass": [
            ((("load", h),), outputs_of(x / np.maximum(total, 1e-9) * np.maximum(total - h, 0)))
            for h in (8.0, 16.0)
        ],
        "compliance": [((), compliance)],
        "shear": [((), shear)],
        "shear_moment": [((), tilt)],
        "temperature_bias": both(warm * ones),
        "temperature_scale": both(warm * x / 5),
        "trial_drift": both(trial_time * ones),
        "session_drift": both(session * ones),
    }  # fmt: skip


def unseen_effects(world: World, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Effects that no row of the library describes, changes (B, n, 3)."""
    trials, n, _ = world.cells.shape
    time = world.time_s - world.time_s[:, :1]
    total = world.cells.sum(-1)
    hum = np.zeros((trials, n, 3))
    hum[..., 0] = np.sin(2 * np.pi * 3.7 * time + rng.uniform(0, 6.28, (trials, 1)))
    edge = np.zeros((trials, n, 3))
    copx = (world.cells * CELL_X_M).sum(-1) / np.maximum(total, 1e-9)
    edge[..., 2] = total * np.maximum(copx - 0.03, 0)
    band = np.zeros((trials, n, 3))
    band[..., 0] = np.exp(-0.5 * ((total - 12) / 1.5) ** 2)
    sticking = np.zeros_like(world.cells)
    sticking[..., 1] = np.sign(world.cells[..., 1] - 4.0) * np.minimum(
        np.abs(world.cells[..., 1] - 4.0), 0.4
    )
    return {"hum": hum, "edge": edge, "band": band, "sticking": outputs_of(sticking)}


def noise_of(world: World, kind: str, rng: np.random.Generator) -> FloatArray:
    """Noise of unit RMS, shape (B, n, 3)."""
    trials, n, _ = world.cells.shape

    def coloured(keep: float) -> FloatArray:
        e = rng.standard_normal((trials, n + 200, 3))
        return np.asarray(lfilter([np.sqrt(1 - keep**2)], [1, -keep], e, axis=1))[:, 200:]

    white = rng.standard_normal((trials, n, 3))
    if kind == "white":
        return white
    if kind == "ar9":
        return coloured(0.9)
    if kind == "ar98":
        return coloured(0.98)
    if kind == "heteroscedastic":
        load = world.cells.sum(-1, keepdims=True)
        level = (0.3 + load / 15) * rng.lognormal(0, 0.4, (trials, 1, 1))
        return np.asarray(level * coloured(0.9) / np.sqrt(np.mean(level**2)))
    noise = 0.8 * coloured(0.9) + 0.4 * white
    shape = outputs_of(world.cells)
    shape = shape / np.sqrt(np.mean(shape**2, axis=(0, 1)))
    noise = noise + 0.3 * rng.standard_normal((trials, 1, 3))
    return np.asarray(noise + 0.3 * rng.standard_normal((trials, 1, 3)) * shape)


def calibration_of(world: World) -> FloatArray:
    """Derivative by four scales and four biases, shape (B, n, 3, 8)."""
    columns = []
    for i in range(4):
        for kind in ("scale", "bias"):
            cells = np.zeros_like(world.cells)
            cells[..., i] = world.cells[..., i] if kind == "scale" else 1.0
            columns.append(outputs_of(cells))
    return np.stack(columns, axis=-1)


def visible_part(world: World, change: FloatArray) -> FloatArray:
    """What one common calibration cannot absorb of a change (B, n, 3), same shape."""
    calibration = calibration_of(world).reshape(-1, 8)
    flat = change.reshape(-1)
    left = flat - calibration @ np.linalg.lstsq(calibration, flat, rcond=None)[0]
    return np.asarray(left.reshape(change.shape))


def sized(world: World, change: FloatArray, rho: float) -> FloatArray:
    """A change scaled so that its visible part has `rho` times the noise's RMS."""
    return np.asarray(rho * change / np.sqrt(np.mean(visible_part(world, change) ** 2)))


def problem_of(world: World, residual: FloatArray, tolerance: float = 0.05) -> Problem:
    """The problem as the bridge would build it, from a residual (B, n, 3)."""
    trials, n, _ = residual.shape

    def rows(values: FloatArray) -> FloatArray:
        """(B, n, 3, ...) -> (B·3·n, ...), each output of a trial one sequence."""
        return np.moveaxis(values, 2, 1).reshape(trials * 3 * n, *values.shape[3:])

    def spread(values: FloatArray) -> FloatArray:
        return rows(np.repeat(values[:, :, None], 3, axis=2))

    signatures, columns = [], []
    for name, shapes in library_effects(world).items():
        for shape, change in shapes:
            signatures.append(Signature(name, name, "all cells", "N", shape))
            columns.append(rows(change))
    index = np.arange(trials * 3)
    total = world.cells.sum(-1)
    cop = outputs_of(world.cells)
    rate = np.gradient(total, axis=1) * RATE_HZ
    safe = np.maximum(total, 3.0)
    x, y = cop[..., 2] * SCALES[2] / safe, cop[..., 1] * SCALES[1] / safe
    return Problem(
        residual=rows(residual),
        calibration=rows(calibration_of(world)),
        columns=np.stack(columns, axis=1),
        signatures=tuple(signatures),
        block=np.repeat(index // 3, n),
        output=np.repeat(index % 3, n),
        sequence=np.repeat(index, n),
        outputs=OUTPUTS,
        units=("N", "Nm", "Nm"),
        noise=np.ones(trials * 3 * n),
        tolerance=np.full(3, tolerance),
        regressors={
            "load": spread(total),
            "load rate": spread(rate),
            "CoP x": spread(x),
            "CoP y": spread(y),
            "shear": spread(world.shear),
            **{f"cell {i}": spread(world.cells[..., i]) for i in range(4)},
            "load × CoP x": spread(cop[..., 2]),
            "load × CoP y": spread(cop[..., 1]),
        },
        rate_hz=RATE_HZ,
        covariates={
            "temperature": world.temperature.mean(1),
            "order of recording": np.arange(float(trials)),
        },
    )

"""A person on two force plates: a cart on a table, plates with errors of a data sheet.

Room: tests of the foreign world; asked by tests of sniffing and of commands.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
G, MASS_KG, HEIGHT_M, RATE_HZ = 9.80665, 71.4, 0.95, 100.0
PLACES_M = np.array([[0.0, 0.15], [0.0, -0.15]])
AXES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")


@dataclass(frozen=True)
class PlateStand:
    """A stand, forces as the plates' amplifiers give them.

    Parameters
    ----------
    time_s, com_m
        Shapes (n,) and (n, 3); the CoM as motion capture has it.
    wrench
        By each plate about its own centre, shape (n, 2, 6), N and Nm.
    cop_m
        Under each foot in the frame of the CoM, shape (n, 2, 2).
    offset
        Of each plate's axes, shape (2, 6).
    """

    time_s: Array
    com_m: Array
    wrench: Array
    cop_m: Array
    offset: Array = field(default_factory=lambda: np.zeros((2, 6)))

    def written(self, path: Path, *, body: bool = True) -> Path:
        """As a table, with or without the CoM."""
        columns = [self.time_s, *self.wrench.reshape(-1, 12).T]
        names = ["Time", *(f"FP{k}_{a}" for k in (1, 2) for a in AXES)]
        if body:
            columns, names = [*columns, *self.com_m.T], [*names, *(f"COM_{a}" for a in "xyz")]
        np.savetxt(path, np.column_stack(columns), fmt="%.6g", delimiter=",",
                   header=",".join(names), comments="")  # fmt: skip
        return path

    def written_as_cop(self, path: Path) -> Path:
        """Vertical forces and CoPs in the frame of the CoM, which stands beside them."""
        cop = np.where(np.abs(self.wrench[:, :, 2:3]) > 15.0, self.cop_m, 0.0)
        both = np.concatenate([self.wrench[:, :, 2:3], cop], axis=2).reshape(-1, 6)
        names = [f"{s}_{n}" for s in "LR" for n in ("Fz", "COPx", "COPy")]
        header = ",".join(["time", *names, *(f"com_{a}" for a in "xyz")])
        np.savetxt(path, np.column_stack([self.time_s, both, self.com_m]), fmt="%.6g",
                   delimiter=",", header=header, comments="")  # fmt: skip
        return path


def plate_stand(
    seed: int, *, gain: Array | None = None, sheet: float = 0.003, shifts: bool = True,
    stances: int = 20, hold_s: float = 3.0,
) -> PlateStand:  # fmt: skip
    """Stances that a person glides between; every fourth is on one foot.

    Parameters
    ----------
    gain
        Of each axis of the first plate, beside what its data sheet allows, shape (6,).
    sheet
        Sd of the gains of all axes.
    shifts
        False: both feet carry half all the time.
    """
    rng = np.random.default_rng(seed)
    share, cop = _demanded(rng, stances, hold_s, shifts=shifts)
    whole = np.einsum("nf,nfk->nk", share, cop)
    com, acc = _above(whole)
    force = np.concatenate(
        [share[:, :, None] * MASS_KG * acc[:, None], share[:, :, None] * MASS_KG * G], axis=2
    )
    x, y = np.moveaxis(cop - PLACES_M, 2, 0)
    fx, fy, fz = np.moveaxis(force, 2, 0)
    true = np.concatenate([force, np.stack([y * fz, -x * fz, x * fy - y * fx], axis=2)], axis=2)
    gains = 1.0 + sheet * rng.normal(size=(2, 6))
    gains[0] *= 1.0 if gain is None else gain
    offset = rng.normal(size=(2, 6)) * [2.0, 2.0, 2.0, 0.5, 0.5, 0.5]
    noise = rng.normal(size=true.shape) * [0.3, 0.3, 0.6, 0.15, 0.15, 0.1]
    body = np.column_stack([com, np.full(len(com), HEIGHT_M)])
    body += 5e-4 * rng.normal(size=3) + 1e-4 * rng.normal(size=body.shape)
    return PlateStand(
        np.arange(len(com)) / RATE_HZ, body, gains * true + offset + noise, cop, offset
    )


def _demanded(
    rng: np.random.Generator, stances: int, hold_s: float, *, shifts: bool
) -> tuple[Array, Array]:
    """Shares of the weight (n, 2) and the CoP under each foot (n, 2, 2)."""
    glide, hold = int(RATE_HZ), int(hold_s * RATE_HZ)
    ramp = np.concatenate([0.5 - 0.5 * np.cos(np.pi * np.linspace(0, 1, glide)), np.ones(hold)])
    share, under = [np.full(hold, 0.5)], [np.zeros((hold, 2, 2))]
    for k in range(stances):
        wanted = float(k // 4 % 2) if k % 4 == 3 else rng.uniform(0.25, 0.75)
        at = rng.uniform(-1.0, 1.0, (2, 2)) * [0.05, 0.02]
        share.append(share[-1][-1] + ((wanted if shifts else 0.5) - share[-1][-1]) * ramp)
        under.append(under[-1][-1] + (at - under[-1][-1]) * ramp[:, None, None])
    left, places = np.concatenate(share), np.concatenate(under)
    sway = np.stack([[_smooth(rng, left.size, sd) for sd in (0.004, 0.003)] for _ in "LR"])
    feet = np.array([[0.0, 0.14], [0.0, -0.14]])
    return np.column_stack([left, 1.0 - left]), feet + places + np.moveaxis(sway, 2, 0)


def _smooth(rng: np.random.Generator, size: int, sd: float) -> Array:
    """Sway below 0.7 Hz."""
    pole = np.exp(-2 * np.pi * 0.7 / RATE_HZ)
    once = lfilter([1 - pole], [1, -pole], rng.normal(size=size))
    twice = lfilter([1 - pole], [1, -pole], once)
    return np.asarray(sd * twice / twice.std())


def _above(cop_m: Array) -> tuple[Array, Array]:
    """CoM and its acceleration (n, 2) by ``c − z c̈ / g = p``, solved in frequencies."""
    n = len(cop_m)
    omega = 2 * np.pi * np.fft.fftfreq(2 * n, 1 / RATE_HZ)[:, None]
    there = np.fft.fft(np.concatenate([cop_m, cop_m[::-1]]), axis=0)
    com = there / (1 + HEIGHT_M / G * omega**2)
    return np.fft.ifft(com, axis=0).real[:n], np.fft.ifft(-(omega**2) * com, axis=0).real[:n]

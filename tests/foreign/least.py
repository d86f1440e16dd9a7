"""Least errors of walks and stands on cells: Cramér–Rao bounds from what is true in this world.

Two bounds, both with the cells' noise, drift and priors as they were drawn (van Trees: information
of the rows and of the priors add). *Load known*: someone knows what every cell felt. *With the
estimator*: total force and its moments are known as well as the estimator of the body says them;
how the soles share it is not known, and a foot in the air feels nothing. The law of its errors is
that of estimators drawn anew on the same motion (masses of links, an IMU, soles, noise): second
moments in frequency, lines that repeat with the gait included. Both know what no command knows:
these laws, when a foot is in the air, delay, stamps and inertia of the plates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from tests.foreign.bench import weights
from tests.foreign.biped import FEET, GRAVITY_MPS2, LINKS, Biped, draw_biped
from tests.foreign.loggers import DRIFT_MEMORY_S, turned
from tests.foreign.motion import FINE_HZ, SOLE_PLACE_M, SOLE_ROLL_M, Motion
from tests.foreign.noise import Array, Rng, stream
from tests.foreign.streams import body_stream, habits, stood, walked

SCALE_SD, ZERO_SHARE = 0.02, 0.02
"""As cells are drawn: of their mean scale, and of the robot's weight."""
AGAIN = {"walk": 32, "stand": 80}
"""Estimators that are drawn anew: more than there are levels of which they show the covariance."""
_SMALL = 1e-3


@dataclass(frozen=True)
class Known:
    """What is known before a walk or a stand.

    Parameters
    ----------
    covariance : (cells, 2, 2) of relative scale and zero (N)
    mass_sd : of the stated mass, relative
    """

    covariance: Array
    mass_sd: float = 0.0


def information(columns: Array, power: Array) -> Array:
    """``(1/n) Σ_k Jᴴ S⁻¹ J`` of stationary noise, (p, p): Whittle's.

    Parameters
    ----------
    columns : (n, r, p) derivatives of r readings
    power : (n, r, r) variance of a reading per frequency of `numpy.fft`; infinite: nothing is read
    """
    seen = np.isfinite(power).all(axis=(1, 2))
    there = np.fft.fft(columns, axis=0)[seen]
    weighted = np.linalg.solve(power[seen], there)
    return np.asarray(np.einsum("nrp,nrq->pq", there.conj(), weighted).real / len(columns))


def white_and_slow(sd: float, n: int, hz: float, at_hz: float, step: float) -> Array:
    """Power (n,) of half white, half AR(1) noise of 0.1 s, recorded with `hz`, seen at `at_hz`.

    `step` is that of the converter; what is faster than the record is not seen.
    """
    frequency = np.fft.fftfreq(n, 1.0 / at_hz)
    decay = np.exp(-1.0 / (0.1 * hz))
    turn = np.exp(-2j * np.pi * frequency / hz)
    slow = (1.0 - decay**2) / np.abs(1.0 - decay * turn) ** 2
    power = (sd**2 * (0.5 + 0.5 * slow) + step**2 / 12.0) * at_hz / hz
    return np.asarray(np.where(np.abs(frequency) <= 0.5 * hz, power, np.inf))


def bench_noise(robot: Biped, time_s: Array, load_n: Array) -> Array:
    """Covariance (n, n) of a cell's readings under weights that are wrong by as much each time."""
    n = load_n.size
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    noise = robot.sd_n**2 * (0.3**2 * np.eye(n) + 0.4**2 * np.exp(-apart / 6.0))
    noise += np.mean(robot.scale**2) / 12.0 * np.eye(n)
    same = np.equal.outer(load_n, load_n)
    noise += (robot.kind.weights_off * np.outer(load_n, load_n) ** 0.5) ** 2 * same
    warm = (robot.kind.warming * robot.weight_n) ** 2
    return np.asarray(noise + warm * np.exp(-_apart(time_s) / DRIFT_MEMORY_S))


def known_before(seed: int, task: str) -> Known:
    """By the name of a task: data sheet, bench, bench and mounted anew."""
    robot = draw_biped(seed)
    plain = np.diag([SCALE_SD**2, (ZERO_SHARE * robot.weight_n) ** 2])
    drift = np.diag([0.0, (robot.kind.warming * robot.weight_n) ** 2])
    if "nameplate" in task:
        mass = 0.01 if task == "online-replay, true nameplate" else 0.0
        return Known(np.tile(plain + drift, (len(robot.channels), 1, 1)), mass)
    anew = np.diag([0.02**2, (0.005 * robot.weight_n) ** 2]) if "anew" in task else 0.0 * plain
    frame, found = weights(seed).logs["weights"], []
    for channel in robot.channels:
        one = frame[frame["channel"] == channel]
        load = one["load_n"].to_numpy()
        a = np.column_stack([load, np.ones(load.size)])
        noise = bench_noise(robot, one["time_s"].to_numpy(), load)
        found.append(np.linalg.inv(a.T @ np.linalg.solve(noise, a) + np.linalg.inv(plain)))
    return Known(np.array(found) + drift + anew, 0.01 if "anew" in task else 0.0)


@dataclass(frozen=True)
class Rows:
    """One recording on the clock of its body stream, in pieces of n samples.

    Parameters
    ----------
    load_n, on : (pieces, n, cells) what cells feel; whether their foot stands
    lever : (pieces, n, 3, cells) of forces: total, and moments about the middle of the feet
    whole : (pieces, n, 3) total force and moments
    drift : (pieces, n, q) shapes of zeros that warm, each with a factor of one sd
    power : (n,) of the noise of a cell
    off : (again, pieces, n, 3) errors of demanded total force and moments
    """

    load_n: Array
    on: Array
    lever: Array
    whole: Array
    drift: Array
    power: Array
    off: Array


def least(rows: Rows, known: Known) -> tuple[Array, Array]:
    """Least sd of relative scales and zeros, (cells, 2): load known, and with the estimator."""
    pieces, n, cells = rows.load_n.shape
    own = np.concatenate(
        [rows.load_n[..., None], np.ones((pieces, n, cells, 1)),
         np.repeat(rows.drift[:, :, None], cells, axis=2)], axis=3,
    )  # fmt: skip
    q = own.shape[3]
    prior = [block_diag(np.linalg.inv(one), np.eye(q - 2)) for one in known.covariance]
    power = rows.power[:, None, None]
    alone = []
    for i in range(cells):
        seen = sum(information(piece[:, i, None], power) for piece in own)
        alone.append(np.sqrt(np.diag(np.linalg.inv(prior[i] + seen))[:2]))
    total = block_diag(*prior, np.array([[known.mass_sd**-2 if known.mass_sd else 1.0]]))
    felt = own * rows.on[..., None]
    columns = np.einsum("snrc,sncq->snrcq", rows.lever, felt).reshape(pieces, n, 3, -1)
    mass = rows.whole[..., None] * (1.0 if known.mass_sd else 0.0)
    carried = np.einsum("snrc,snc->snrc", rows.lever, rows.on)
    columns = np.concatenate([columns, -mass], axis=3)
    total += demanded(columns, carried, rows.power, rows.off)
    for i in range(cells):
        at = slice(q * i, q * i + q)
        for piece, on in zip(own, rows.on, strict=True):
            idle = piece[:, i] * (1.0 - on[:, i, None])
            total[at, at] += information(idle[:, None], power)
    sd = np.sqrt(np.diag(np.linalg.inv(total))[:-1]).reshape(cells, q)
    return np.array(alone), sd[:, :2]


def demanded(columns: Array, carried: Array, power: Array, off: Array) -> Array:
    """Information of rows that a body demands: levels of all pieces together, else each alone.

    Parameters
    ----------
    columns : (pieces, n, r, p) derivatives of the rows
    carried : (pieces, n, r, channels) how readings stand in the rows, noise of one relative sd
    power : (n,) of that noise
    off : (again, pieces, n, r) errors of what is demanded
    """
    again, pieces, n, r = off.shape
    seen = np.fft.fft(off, axis=2) / np.sqrt(n)
    law = np.einsum("asni,asnj->nij", seen, seen.conj()) / (again * pieces)
    law *= again * pieces / (again * pieces - r - 1.0)  # the inverse of a mean of squares leans
    each = np.einsum("snrc,sntc->srt", carried, carried) / n
    law = law + power[:, None, None] * each.mean(axis=0)
    law[0] = np.inf
    found = sum(information(piece, law) for piece in columns)
    size = r * pieces
    levels = seen[:, :, 0].real.reshape(again, size)
    noise = levels.T @ levels / (again - size - 1.0) + power[0] * block_diag(*each)
    at = (columns.sum(axis=1) / np.sqrt(n)).reshape(size, -1)
    return np.asarray(found + at.T @ np.linalg.solve(noise, at))


def rows_of(seed: int, what: str, again: int | None = None) -> Rows:
    """Of a `walk` or a `stand`."""
    robot = draw_biped(seed)
    motions = [walked(seed)] if what == "walk" else stood(seed)
    _, cells_hz, hz, loss = habits(robot, stream(seed, f"{what} logged"))
    every = round(FINE_HZ / hz)
    hz = FINE_HZ / every
    plans = [motion.plan for motion in motions]
    count = len(robot.cells)
    load = np.stack([motion.cells_n[::every] for motion in motions])
    share = np.stack([plan.share[::every] for plan in plans])
    lever, whole = (
        np.stack(one)
        for one in zip(*(_balance(robot, motion, every) for motion in motions), strict=True)
    )
    n = load.shape[1]
    step = float(np.sqrt(np.mean(robot.scale**2)))
    return Rows(
        load, np.repeat(share > 0.0, count, axis=2).astype(float), lever, whole,
        _drifts(robot, np.stack([plan.time_s[::every] for plan in plans]), at_end=what == "walk"),
        white_and_slow(robot.sd_n, n, cells_hz, hz, step),
        np.stack([
            np.stack([_off(one, motion, rng, hz, lost) for motion in motions])
            for one, rng, lost in estimators(robot, seed, loss, again or AGAIN[what])
        ]),
    )  # fmt: skip


def _balance(robot: Biped, motion: Motion, every: int) -> tuple[Array, Array]:
    """Levers (n, 3, cells) and total force and moments (n, 3) about the middle of the feet."""
    plan = motion.plan
    feet, yaw = plan.feet_m[::every, :, :2], plan.yaw_rad[::every]
    middle = feet.mean(axis=1)
    place = np.concatenate(
        [(feet[:, side] - middle)[:, None] + _around(robot.cells_m, yaw[:, side])
         for side in range(len(FEET))], axis=1,
    )  # fmt: skip
    lever = np.concatenate([np.ones((len(place), 1, place.shape[1])), place.swapaxes(1, 2)], axis=1)
    com, acc, turning = motion.com_m[::every], motion.com_acc_mps2[::every], motion.angmom_rate_nm
    moments = _moments(robot, com, acc, turning[::every], middle)
    return lever, np.column_stack([_total(robot, acc), moments])


def _around(points: Array, yaw: Array) -> Array:
    """Points (c, 2) turned by yaw (n,), shape (n, c, 2)."""
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y = points.T
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _total(robot: Biped, acc: Array) -> Array:
    return np.asarray(robot.mass_kg * (acc[:, 2] + GRAVITY_MPS2))


def _moments(robot: Biped, com: Array, acc: Array, turning: Array, about: Array) -> Array:
    """Σ F (x, y) of the ground about a point, (n, 2): Newton and Euler."""
    swing = np.column_stack([turning[:, 1], -turning[:, 0]])
    level = _total(robot, acc)[:, None] * (com[:, :2] - about)
    return np.asarray(level - com[:, 2:] * robot.mass_kg * acc[:, :2] - swing)


def estimators(robot: Biped, seed: int, loss: float, again: int) -> list[tuple[Biped, Rng, float]]:
    """Estimators of the same make: masses of links, the lean of an IMU, lost momentum."""
    found = []
    for k in range(again):
        rng = stream(seed, f"estimator {k}")
        believed = robot.masses_kg * (1.0 + rng.normal(0.0, 0.02, LINKS))
        other = replace(
            robot, believed_masses_kg=robot.mass_kg * believed / believed.sum(),
            tilt_rad=rng.normal(0.0, 0.002, 2),
        )  # fmt: skip
        lost = loss if robot.kind.momentum_loss is not None else float(rng.uniform(0.15, 0.25))
        found.append((other, rng, lost))
    return found


def rolled(robot: Biped, motion: Motion, rng: Rng, every: int) -> Array:
    """How far soles lie from where the joints have them, drawn as this world does, (n, 2, 2)."""
    plan, size = motion.plan, robot.kind.size
    number, share = plan.number[::every].astype(int), plan.share[::every]
    place, roll = (
        sd * size * rng.normal(size=(number.max() + 1, 2, 2)) for sd in (SOLE_PLACE_M, SOLE_ROLL_M)
    )
    foot = np.arange(len(FEET))
    return np.asarray(place[number, foot] + roll[number, foot] * (share - 0.5)[..., None])


def _off(robot: Biped, motion: Motion, rng: Rng, hz: float, loss: float) -> Array:
    """What an estimator demands less what is true, (n, 3), with soles that it cannot see."""
    frame, _ = body_stream(robot, motion, rng, hz, loss)
    plan, every = motion.plan, round(FINE_HZ / hz)
    angle = robot.kind.yaw_drift_radps * plan.time_s[::every]
    share, feet = plan.share[::every], plan.feet_m[::every, :, :2]

    def vector(pattern: str, axes: str = "xyz") -> Array:
        return turned(frame[[pattern.format(axis) for axis in axes]].to_numpy(), -angle)

    seen = np.stack([vector(f"{foot}_foot_{{}}_m", "xy") for foot in FEET], axis=1)
    middle = seen.mean(axis=1)
    acc = vector("com_acc_{}_mps2")
    there = "angmom_rate_x_nm" in frame
    turning = vector("angmom_rate_{}_nm", "xy") if there else np.zeros((len(acc), 2))
    demanded = _moments(robot, vector("com_{}_m"), acc, turning, middle)
    _, whole = _balance(robot, motion, every)
    load = share * whole[:, :1]
    shift = rolled(robot, motion, rng, every)
    shift -= (seen - middle[:, None]) - (feet - feet.mean(axis=1)[:, None])
    return np.column_stack([
        _total(robot, acc) - whole[:, 0],
        demanded - whole[:, 1:] + np.einsum("nf,nfk->nk", load, shift),
    ])  # fmt: skip


def _apart(time_s: Array) -> Array:
    return np.abs(np.subtract.outer(time_s, time_s))


def _drifts(robot: Biped, time_s: Array, *, at_end: bool) -> Array:
    """Shapes (pieces, n, q) of drift from its level at the end, or from its mean."""
    sd = robot.kind.warming * robot.weight_n
    if not sd:
        return np.zeros((*time_s.shape, 0))
    coarse = time_s[:, :: max(time_s.shape[1] // 60, 1)].ravel()
    kept = np.zeros((coarse.size, coarse.size))
    kept[:, -1] = 1.0
    if not at_end:
        kept[:] = 1.0 / coarse.size
    from_level = np.eye(coarse.size) - kept
    law = from_level @ np.exp(-_apart(coarse) / DRIFT_MEMORY_S) @ from_level.T
    size, shape = np.linalg.eigh(law)
    use = size > _SMALL * size[-1]
    each = sd * shape[:, use] * np.sqrt(size[use])
    return np.stack(
        [np.interp(time_s, coarse, one) for one in each.T], axis=-1
    )  # fmt: skip

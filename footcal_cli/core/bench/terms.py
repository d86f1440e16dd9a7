"""What a channel may do beyond scale and bias: distortions of the table of effects as regressors.

Every distortion used here is linear in its size, ``y = x + size · φ(x; shape)``, so that
φ = apply(x; size = 1) − x: the ladder, the simulator and every chain share one equation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.effects.cells import (
    NONLINEARITY,
    NONLINEARITY_CUBIC,
    TEMPERATURE_BIAS,
    TEMPERATURE_SCALE,
)
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.memory_effects import (
    BIAS_DRIFT,
    BIAS_JUMP,
    CREEP,
    CREEP_SLOW,
    HYSTERESIS,
)
from footcal_cli.core.parameters import FloatArray

Distortion = Callable[[FloatArray, BenchRecord, FloatArray], FloatArray]

_REACHES = (0.01, 0.03, 0.1, 0.2, 0.4)
"""Reaches of the play worth trying, as shares of full scale."""
_STACK = (0.05, 0.2, 0.5)
"""Reaches of the Prandtl–Ishlinskii stack, as shares of full scale."""
_STEPS_OF_TIME = 10
_TIMES_OF_A_JUMP = 40
_SHARES_OF_A_JUMP = np.arange(0.05, 0.96, 0.05)


@dataclass(frozen=True)
class Term:
    """One distortion with a size to fit linearly and shapes to search.

    Parameters
    ----------
    owner
        Suffix to the channel's name where an effect occurs more than once (``_wide``).
    shapes, shape_units
        Names and units of the shapes.
    grids
        Values worth trying for each shape.
    free
        Whether the shapes are searched; else the first of each grid is used.
    phi
        ``φ(load (n,), record, shapes (k,))``, shape (n,).
    effect
        Name in the table of effects; empty for a term that has no row there.
    """

    owner: str
    size: str
    unit: str
    phi: Distortion
    shapes: tuple[str, ...] = ()
    shape_units: tuple[str, ...] = ()
    grids: tuple[tuple[float, ...], ...] = ()
    free: bool = True
    effect: str = ""


@dataclass(frozen=True)
class Rung:
    """A named extension of the affine model.

    Parameters
    ----------
    name
        As reports say it.
    needs_time, needs_temperature
        What the record must have.
    """

    name: str
    terms: tuple[Term, ...]
    needs_time: bool = False
    needs_temperature: bool = False

    @property
    def cost(self) -> int:
        """Numbers it adds to the affine model."""
        return sum(1 + (len(term.shapes) if term.free else 0) for term in self.terms)

    def fits(self, record: BenchRecord) -> bool:
        """Whether the record has what this rung needs."""
        warmth = record.temperature_degc
        warm = warmth is not None and float(np.ptp(warmth)) > 0.5
        return (record.timed or not self.needs_time) and (warm or not self.needs_temperature)


def effect_term(
    effect: Effect, grids: tuple[tuple[float, ...], ...] = (), owner: str = "", free: bool = True
) -> Term:
    """A term from a row of the table of effects.

    Parameters
    ----------
    effect
        Linear in its size.
    grids
        Values worth trying for each shape, in place of the table's.
    owner, free
        See `Term`.
    """
    shapes = effect.parameters[1:]

    def phi(load_n: FloatArray, record: BenchRecord, values: FloatArray) -> FloatArray:
        at, theta = record.changed_at, {effect.size.name: np.ones(1)}
        theta |= {shape.name: np.array([v]) for shape, v in zip(shapes, values, strict=True)}
        stood = load_n if at is None else np.insert(load_n, at, load_n[at - 1])
        applied, _ = effect.apply(record.as_log.with_readings(stood[:, None]), theta, None)
        shown = applied.readings[:, 0]
        if at is not None:
            shown = np.delete(shown, at + np.arange(at.size))
        return np.asarray(shown - load_n)

    return Term(
        owner=owner,
        size=effect.size.name,
        unit=effect.size.unit,
        phi=phi,
        shapes=tuple(shape.name for shape in shapes),
        shape_units=tuple(shape.unit for shape in shapes),
        grids=grids or tuple(shape.grid for shape in shapes),
        free=free,
        effect=effect.name,
    )


def power_term(degree: int) -> Term:
    """``φ = x^degree``: the polynomial beyond the cubic of the table of effects."""

    def phi(load_n: FloatArray, _record: BenchRecord, _shapes: FloatArray) -> FloatArray:
        return np.asarray(load_n**degree)

    exponent = str(degree - 1).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return Term("", f"power_{degree}", f"1/N{exponent}", phi)


def polynomial(degree: int) -> Rung:
    """Scale and bias with powers of the load up to `degree`."""
    powers = [effect_term(NONLINEARITY), effect_term(NONLINEARITY_CUBIC)]
    powers += [power_term(k) for k in range(4, degree + 1)]
    return Rung(f"polynomial {degree}", tuple(powers[: degree - 1]))


def hysteresis(full_scale_n: float) -> Rung:
    """One play whose reach is searched."""
    reaches = tuple(share * full_scale_n for share in _REACHES)
    return Rung(HYSTERESIS.name, (effect_term(HYSTERESIS, (reaches,)),))


def hysteresis_stack(full_scale_n: float) -> Rung:
    """Prandtl–Ishlinskii: plays of three fixed reaches side by side."""
    return Rung(
        "hysteresis, three plays",
        tuple(
            effect_term(HYSTERESIS, ((share * full_scale_n,),), owner, free=False)
            for share, owner in zip(_STACK, ("", "_mid", "_wide"), strict=True)
        ),
    )


def creep(record: BenchRecord, constants: int) -> Rung:
    """Creep with one or two time constants between the sample interval and the longest session."""
    longest = record.longest_s
    gaps = np.diff(record.time_s)
    shortest = max(2.0 * float(np.median(gaps[gaps > 0])) if np.any(gaps > 0) else 1.0, 1.0)
    grid = tuple(np.geomspace(min(shortest, longest / 4.0), 2.0 * longest, _STEPS_OF_TIME))
    effects = (CREEP, CREEP_SLOW)[:constants]
    return Rung(
        CREEP.name + ", two time constants" * (constants > 1),
        tuple(effect_term(effect, (grid,)) for effect in effects),
        needs_time=True,
    )


def drift() -> Rung:
    """A bias that moves steadily in time: what creep must be distinguished from."""
    return Rung("bias drift", (effect_term(BIAS_DRIFT, ((0.0,),), free=False),), needs_time=True)


def warm_up_rung(record: BenchRecord) -> Rung:
    """A zero that settles after the start; slower than the longest session it is a drift."""
    longest = record.longest_s
    return Rung(
        "warm-up", (effect_term(BIAS_DRIFT, (tuple(np.geomspace(1.0, 33.0, 8) / longest),)),),
        needs_time=True,
    )  # fmt: skip


def jump(record: BenchRecord) -> Rung:
    """A bias that jumps once: in the pauses where loads are changed, or in between."""
    since = np.sort(record.time_s) - record.time_s.min()
    longest = np.argsort(np.diff(since), kind="stable")[-_TIMES_OF_A_JUMP:]
    times = np.union1d(0.5 * (since[longest] + since[longest + 1]), since[-1] * _SHARES_OF_A_JUMP)
    return Rung("bias jump", (effect_term(BIAS_JUMP, (tuple(times),)),), needs_time=True)


def temperature() -> tuple[Rung, Rung]:
    """Temperature on the bias alone, and on bias and scale."""
    bias, scale = effect_term(TEMPERATURE_BIAS), effect_term(TEMPERATURE_SCALE)
    return (
        Rung("temperature on bias", (bias,), needs_temperature=True),
        Rung("temperature on bias and scale", (bias, scale), needs_temperature=True),
    )


def menu(record: BenchRecord, most_degree: int = 3) -> tuple[Rung, ...]:
    """All rungs that a record could support, simple ones first.

    A polynomial needs two distinct loads more than its degree. Up to the third degree every rung is
    in the table of effects, so that any command can use the model that was chosen.
    """
    loads = np.unique(np.round(record.load_n[record.known], 9)).size
    degrees = range(2, min(most_degree, loads - 2) + 1)
    scale = record.full_scale_n
    running = bool(record.timed and record.longest_s)
    alone = running and np.unique(record.session).size == 1
    rungs = (
        *(polynomial(degree) for degree in degrees),
        *temperature(),
        hysteresis(scale),
        hysteresis_stack(scale),
        *((drift(),) if record.timed else ()),
        *((creep(record, 1), creep(record, 2), warm_up_rung(record)) if running else ()),
        *((jump(record),) if alone else ()),
    )
    return tuple(sorted((r for r in rungs if r.fits(record)), key=lambda rung: rung.cost))

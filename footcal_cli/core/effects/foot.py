"""What happens between the ground and the cells of a foot."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.effects.contract import (
    ArrayTransform,
    Effect,
    EffectParameter,
    GridOf,
    Scope,
    Stage,
    State,
    Theta,
    Trait,
    columns_of,
    is_six_axis,
    on_known,
    on_readings,
    plus,
)
from footcal_cli.core.effects.memory import elapsed
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, IntArray

_UNLOADED_N = 1e-9


def _feet(log: Log) -> tuple[IntArray, ...]:
    """Columns of each foot's cells; none where the channels are six-axis."""
    return () if is_six_axis(log.channels) else columns_of(Scope.FOOT, log.channels)


def _foot_yaw(log: Log) -> FloatArray:
    """Yaw of the foot under each channel, shape (n, c)."""
    yaw = log.known.get("foot_yaw_rad")
    spread = np.zeros((len(log), len(log.channels)))
    if yaw is not None:
        for i, cells in enumerate(columns_of(Scope.FOOT, log.channels)):
            spread[:, cells] = yaw[:, i : i + 1]
    return spread


def turned(x: FloatArray | float, y: FloatArray | float, yaw_rad: FloatArray | float) -> FloatArray:
    """Horizontal vectors turned by yaws, shape (..., 2)."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def _shift_horizontally(pos: FloatArray, shift: FloatArray) -> FloatArray:
    moved = pos.copy()
    moved[..., :2] += shift
    return moved


def _cell_position(sign: float) -> ArrayTransform:
    def moved(pos: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        if is_six_axis(log.channels):
            return pos, state
        x, y = theta["cell_correction_x"], theta["cell_correction_y"]
        return _shift_horizontally(pos, sign * turned(x, y, _foot_yaw(log))), state

    return moved


def _slip(sign: float) -> ArrayTransform:
    def moved(pos: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
        if is_six_axis(log.channels):
            return pos, state
        since, state = elapsed(log, state)
        shift = np.zeros((len(log), len(log.channels), 2))
        for i, cells in enumerate(columns_of(Scope.FOOT, log.channels)):
            slid = np.clip((since - theta["slip_time"][i]) / theta["slip_duration"][i], 0.0, 1.0)
            slip = np.array([theta["slip_x"][i], theta["slip_y"][i]])
            shift[:, cells] = slid[:, None, None] * slip
        return _shift_horizontally(pos, sign * shift), state

    return moved


def _bypass(x: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    y = x.copy()
    for i, cells in enumerate(_feet(log)):
        total = x[:, cells].sum(axis=1, keepdims=True)
        beside = theta["load_bypass"][i] * np.maximum(total - theta["bypass_load"][i], 0.0)
        y[:, cells] *= 1.0 - beside / np.maximum(total, _UNLOADED_N)
    return y, state


def _unbypass(y: FloatArray, log: Log, theta: Theta, state: State) -> tuple[FloatArray, State]:
    x = y.copy()
    for i, cells in enumerate(_feet(log)):
        share, touch = theta["load_bypass"][i], theta["bypass_load"][i]
        total = y[:, cells].sum(axis=1, keepdims=True)
        beside = share / (1.0 - share) * np.maximum(total - touch, 0.0)
        x[:, cells] *= 1.0 + beside / np.maximum(total, _UNLOADED_N)
    return x, state


def _plate(log: Log, theta: Theta) -> FloatArray:
    hung = np.zeros((len(log), len(log.channels)))
    if "contact" in log.known:
        # a filtered reading changes over a transition, which detected contact leaves open
        hanging = log.known.get("airborne", log.known["contact"] == 0.0)
        for i, cells in enumerate(_feet(log)):
            hung[:, cells] = theta["plate_weight"][i] / len(cells) * hanging[:, i : i + 1]
    return hung


CELL_POSITION = Effect(
    name="cell_position",
    traits=(Trait.BELIEF, Trait.MIXTURE),
    stage=Stage.FOOT,
    scope=Scope.CHANNEL,
    parameters=(
        EffectParameter("cell_correction_x", "m", 0.0, -0.05, 0.05, 0.002),
        EffectParameter("cell_correction_y", "m", 0.0, -0.05, 0.05, 0.002),
    ),
    apply=on_known("cell_pos_m", _cell_position(-1.0)),
    remove=on_known("cell_pos_m", _cell_position(1.0)),
    experiments=("placements", "stand", "walk"),
    formula="true cell position = believed position + δ, in foot axes",
    source="NAO CoP self-calibration, eqs. (3)–(5): the offline CoP correction absorbs it",
    remedy="measure the cells' places; check the model's foot",
    needs=("cell_pos_m",),
    mimics=("crosstalk", "com_offset"),
    separates="a weight placed on the holes above each cell",
)

SLIP = Effect(
    name="slip",
    traits=(Trait.TIMED, Trait.MEMORY),
    unseen_walking="happens once, and nothing that does not repeat is evidence; track the feet",
    stage=Stage.FOOT,
    scope=Scope.FOOT,
    parameters=(
        EffectParameter("slip_x", "m", 0.0, -0.5, 0.5, 0.01),
        EffectParameter("slip_y", "m", 0.0, -0.5, 0.5, 0.01),
        EffectParameter(
            "slip_time", "s", 20.0, 0.0, 1e6, 20.0, True, (5.0, 10.0, 20.0, 30.0, 60.0)
        ),
        EffectParameter("slip_duration", "s", 0.5, 0.01, 1e3, 0.5, True, (0.1, 0.5, 2.0)),
    ),
    apply=on_known("cell_pos_m", _slip(-1.0)),
    remove=on_known("cell_pos_m", _slip(1.0)),
    experiments=("stand", "walk"),
    of_recording=True,
    formula="true foot = believed foot + δ · clip((t − t₀ − t_s) / T, 0, 1), in the world",
    source="NAO CoP self-calibration, section 5.1 (slip); Newton–Euler holds while sliding",
    remedy="put a rubber sole on the foot, or track the feet with a camera",
    needs=("cell_pos_m",),
    mimics=("com_offset", "wrong_hole"),
    separates="motion capture of the foot",
)

LOAD_BYPASS = Effect(
    name="load_bypass",
    traits=(Trait.OF_THE_SUM,),
    stage=Stage.FOOT,
    scope=Scope.FOOT,
    parameters=(
        EffectParameter("load_bypass", "-", 0.0, 0.0, 0.9, 0.05),
        EffectParameter(
            "bypass_load", "N", 20.0, 0.0, 1e4, 20.0, True, (0.0, 0.2, 0.4, 0.6, 0.8), GridOf.LOAD
        ),
    ),
    apply=on_readings(_bypass),
    remove=on_readings(_unbypass),
    experiments=("placements", "stand", "walk"),
    formula="cells carry F − s · max(F − F_touch, 0) of the foot's load F, in proportion",
    source="a stop, cable or shell that touches parallel to the cells",
    remedy="look for a second load path parallel to the cells and clear it",
    mimics=("nonlinearity", "mass", "hinge"),
    separates="load single cells with weights: a bypass answers to the sum, a curve to each cell",
)

HANGING_PLATE = Effect(
    name="hanging_plate",
    stage=Stage.FOOT,
    scope=Scope.FOOT,
    parameters=(EffectParameter("plate_weight", "N", 0.0, -20.0, 20.0, 0.5),),
    apply=on_readings(plus(_plate, -1.0)),
    remove=on_readings(plus(_plate)),
    experiments=("walk",),
    formula="y_i = x_i − W / cells while the foot is in the air: the loose sole hangs on the cells",
    source="the feet of the NAO CoP paper; a sole that rests on the floor in stance and hangs in "
    "swing",
    remedy="fix the sole to the cells' seats, or weigh it and give its weight to the recipe",
    needs=("contact",),
    mimics=("scale_bias", "bias_drift"),
    separates="lift the foot with and without its sole",
)


def _inertia(log: Log, theta: Theta) -> FloatArray:
    force = np.zeros((len(log), len(log.channels)))
    if "foot_acc_mps2" in log.known:
        acceleration = log.known["foot_acc_mps2"]
        for foot, own in enumerate(columns_of(Scope.FOOT, log.channels)):
            force[:, own] = theta["plate_mass"][foot] * acceleration[:, foot, 2:] / own.size
    return force


PLATE_INERTIA = Effect(
    name="plate_inertia",
    stage=Stage.FOOT,
    scope=Scope.FOOT,
    parameters=(EffectParameter("plate_mass", "kg", 0.0, -5.0, 5.0, 0.1),),
    apply=on_readings(plus(_inertia, -1.0)),
    remove=on_readings(plus(_inertia)),
    experiments=("walk",),
    formula="y_i = x_i − m a / cells, a the vertical acceleration of the foot",
    source="Newton: cells drive what is mounted below them; its weight is part of their bias",
    remedy="weigh what hangs below the cells",
    needs=("foot_acc_mps2",),
)
"""No row of the table: every plate below cells has it, and it is fitted beside every cause."""

EFFECTS = (CELL_POSITION, SLIP, LOAD_BYPASS, HANGING_PLATE)

"""Robots of many makes: what they weigh, what they stand on, and how they are logged.

A seed draws a robot of the make ``seed % DRAW``, and the usual one where `FLEET` has no such key:
7003, 107003 and 207003 are three robots of one make.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """One make of robot, its loggers and its owner's habits.

    Parameters
    ----------
    name : what its owner calls it
    mass_kg : between these; lengths grow with its cube root
    cells : 3, 4 or 6 under each foot; 0: a six-axis transducer at each ankle
    legs : 0: a biped; else how many legs with six-axis transducers at the hips
    bits : of the converter over four body weights; 0: as fine as a 24 bit one
    hysteresis : half width of the loop, share of the robot's weight
    noise : of the cells, relative to the usual
    warming : drift of zeros from warming, share of body weight per hour
    cells_hz, body_hz : 0: drawn
    jitter_s, stamp_s : sd of the stamps, and what they are rounded to
    lost : share of packets that are lost
    delay_s : of the estimator; None: drawn
    smooth_s : width of its smoothing
    yaw_drift_radps : of its heading
    momentum_loss : part of the angular momentum that it does not know; None: drawn
    mass_off : error of the mass in the recipe, relative
    repeats, ladder : sessions of the bench, and its loads by share of the largest
    weights_off : relative sd of its weights
    turn_s, rate_hz : of hanging legs
    share_drift : part of the noise that lasts from pose to pose
    span : of the converter of a transducer, relative to twice the robot's weight
    ankle_roll : how far a swinging sole rolls, rad; it pitches in any case
    plate : mass of the plate under a cell, relative to the usual
    """

    name: str = "usual biped"
    mass_kg: tuple[float, float] = (4.0, 9.0)
    cells: int = 4
    legs: int = 0
    bits: int = 0
    hysteresis: float = 0.0
    noise: float = 1.0
    warming: float = 0.0
    cells_hz: float = 0.0
    body_hz: float = 0.0
    jitter_s: float = 0.0
    stamp_s: float = 1e-5
    lost: float = 0.0
    delay_s: float | None = None
    smooth_s: float = 0.0
    yaw_drift_radps: float = 0.0
    momentum_loss: float | None = None
    mass_off: float = 0.0
    repeats: int = 4
    ladder: tuple[float, ...] = (0.0, 0.1, 0.25, 0.5, 1.0)
    weights_off: float = 5e-5
    turn_s: float = 20.0
    rate_hz: float = 25.0
    share_drift: float = 0.3
    span: float = 1.0
    ankle_roll: float = 0.0
    plate: float = 1.0

    @property
    def size(self) -> float:
        """Lengths relative to a robot of 6.5 kg."""
        return float((0.5 * sum(self.mass_kg) / 6.5) ** (1.0 / 3.0))


_USUAL = Kind()
_HEXAPOD = (6.0, 12.0)
FLEET = {
    7001: Kind("NAO-sized, 24 bits", (5.2, 5.4), cells_hz=80.0, body_hz=100.0),
    7002: Kind("usual biped", cells_hz=100.0, body_hz=200.0),
    7003: Kind("pocket biped on FSRs", (1.1, 1.3), bits=10, hysteresis=0.02, noise=4.0,
               cells_hz=50.0, body_hz=50.0, weights_off=2e-3),
    7004: Kind("toy on three cells", (1.8, 2.2), cells=3, bits=12, cells_hz=40.0, body_hz=100.0,
               jitter_s=2e-3, stamp_s=1e-3, repeats=1),
    7005: Kind("kid size on six cells", (7.5, 8.5), cells=6, bits=16, cells_hz=200.0,
               body_hz=100.0, lost=0.05),
    7006: Kind("late, smooth estimator", (5.0, 7.0), cells_hz=100.0, body_hz=100.0, delay_s=0.1,
               smooth_s=0.04),
    7007: Kind("teen size, 1 kHz", (14.0, 16.0), bits=16, cells_hz=1000.0, body_hz=200.0),
    7008: Kind("heavy biped, 2 kHz", (40.0, 50.0), cells_hz=2000.0, body_hz=400.0, repeats=3,
               weights_off=1e-3),
    7009: Kind("exoskeleton, warming", (85.0, 90.0), cells=6, bits=16, warming=0.003,
               cells_hz=100.0, body_hz=100.0, repeats=2, ladder=(0.0, 0.3, 0.6, 1.0)),
    7010: Kind("mass 5 % too large", (9.0, 11.0), cells_hz=100.0, body_hz=100.0, mass_off=0.05),
    7011: Kind("20 Hz", (3.5, 4.5), bits=16, cells_hz=20.0, body_hz=20.0, jitter_s=3e-3),
    7012: Kind("heading drifts", (6.0, 8.0), cells_hz=100.0, body_hz=200.0,
               yaw_drift_radps=0.003, momentum_loss=1.0),
    7013: Kind("small, six-axis ankles", (4.0, 5.0), cells=0, cells_hz=100.0, body_hz=100.0),
    7014: Kind("30 kg, six-axis ankles", (28.0, 32.0), cells=0, cells_hz=200.0, body_hz=200.0,
               lost=0.02),
    7015: Kind("adult, six-axis ankles, 50 Hz", (65.0, 75.0), cells=0, cells_hz=50.0, body_hz=50.0,
               smooth_s=0.03, momentum_loss=1.0),
    7016: Kind("six-axis ankles, mass 5 % off", (20.0, 24.0), cells=0, cells_hz=100.0,
               body_hz=100.0, mass_off=-0.05),
    7017: Kind("usual hexapod", _HEXAPOD, legs=6),
    7018: Kind("hexapod, 6 s a turn", _HEXAPOD, legs=6, turn_s=6.0, share_drift=0.0),
    7019: Kind("quadruped, 100 Hz", (11.0, 14.0), legs=4, rate_hz=100.0, turn_s=10.0),
    7020: Kind("heavy hexapod", (55.0, 65.0), legs=6, turn_s=30.0, noise=4.0),
    7021: Kind("small hexapod, 12 bits", (1.3, 1.7), legs=6, bits=12, noise=0.3),
    7022: Kind("quadruped, mass 5 % too small", (28.0, 32.0), legs=4, noise=2.0, mass_off=-0.05),
    7023: Kind("hexapod, warming", _HEXAPOD, legs=6, warming=0.01, share_drift=0.0),
    7024: Kind("eight legs, 60 s a turn", _HEXAPOD, legs=8, turn_s=60.0, rate_hz=10.0),
    7101: Kind("70 kg, ankles of two axes", (68.0, 72.0), cells=0, cells_hz=200.0, body_hz=200.0,
               ankle_roll=0.08),
    7102: Kind("transducers of ten times the range", _HEXAPOD, legs=6, bits=16, noise=10.0,
               span=10.0),
    7103: Kind("legs of 200 g, 6 s a turn", (2.7, 3.0), legs=6, noise=0.5, turn_s=6.0),
    7104: Kind("legs of 200 g, 20 s a turn", (2.7, 3.0), legs=6, noise=0.5),
    7105: Kind("legs of 200 g, 60 s a turn", (2.7, 3.0), legs=6, noise=0.5, turn_s=60.0,
               rate_hz=10.0),
    7106: Kind("laboratory with y up", (5.0, 7.0), cells_hz=100.0, body_hz=100.0),
    7107: Kind("north east down", (5.0, 7.0), cells_hz=100.0, body_hz=100.0),
    7108: Kind("left-handed transducers", _HEXAPOD, legs=6),
    7109: Kind("gravity from an IMU", _HEXAPOD, legs=6),
    7110: Kind("wrist sensor with a tool"),
    7111: Kind("quadruped on points", (6.0, 20.0)),
    7201: Kind("150 kg, 500 Hz", (140.0, 160.0), bits=16, cells_hz=500.0, body_hz=400.0),
    7202: Kind("half a kilogram on three cells", (0.45, 0.6), cells=3, bits=12, cells_hz=30.0,
               body_hz=50.0),
    7203: Kind("stamps of 10 ms", (5.0, 8.0), cells_hz=125.0, body_hz=100.0, jitter_s=4e-3,
               stamp_s=1e-2),
    7204: Kind("10 bits, plates of 150 g", (6.0, 7.0), bits=10, cells_hz=60.0, body_hz=200.0,
               plate=6.0, momentum_loss=0.4),
    7205: Kind("110 kg on ankles, rolling soles", (105.0, 115.0), cells=0, cells_hz=500.0,
               body_hz=400.0, ankle_roll=0.12, jitter_s=1e-3),
    7206: Kind("quadruped of 300 kg, 14 bits", (270.0, 330.0), legs=4, bits=14, noise=8.0),
    7207: Kind("ten legs, 6 s a turn", (10.0, 15.0), legs=10, turn_s=6.0, rate_hz=50.0),
    7208: Kind("pocket hexapod, 60 s a turn", (0.8, 1.0), legs=6, bits=12, noise=0.2,
               turn_s=60.0, rate_hz=20.0),
}  # fmt: skip
"""Make -> kind."""
DRAW = 100_000
"""Seeds of one make lie this far apart."""


def kind_of(seed: int) -> Kind:
    """The kind that a seed draws."""
    return FLEET.get(seed % DRAW, _USUAL)

"""What all mountings of a standing robot have in common: another cause would look the same.

A shift that all hips share is that of the chassis' CoM the other way round: standing shows only
their difference, and hips do not move together by more than they scatter.

Poses see how each transducer is turned against the body frame that the markers define. If that
frame itself is tilted, every mounting comes out turned by the same rotation, and no pose can tell
which of the two it is. Mountings that only scatter have a common part of about their scatter over
the square root of the number of legs; more than that has one cause.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.parameters import FloatArray

COMMON_P = 1e-3
"""A robot whose mountings only scatter is said to share a turn or a shift this often."""


@dataclass(frozen=True)
class CommonTurn:
    """The mean turn of all mountings, roll and pitch in body axes.

    Parameters
    ----------
    turn_rad
        Mean over the legs, shape (2,).
    half_rad
        Half width of the 95 % interval of each, from the scatter of the legs, shape (2,).
    scatter_rad
        Sd of the legs about the mean, both axes together.
    p
        That legs which only scatter have such a mean (Hotelling's T²).
    """

    turn_rad: FloatArray
    half_rad: FloatArray
    scatter_rad: float
    p: float

    @property
    def stands_out(self) -> bool:
        """Whether scatter alone does not explain it."""
        return self.p < COMMON_P

    @property
    def words(self) -> str:
        """Size and scatter, in degrees."""
        roll, pitch = np.rad2deg(self.turn_rad)
        wide = np.rad2deg(self.half_rad)
        return (
            f"all mountings are turned alike, roll {roll:.2f} ± {wide[0]:.2f}° and pitch "
            f"{pitch:.2f} ± {wide[1]:.2f}°, and scatter by {np.rad2deg(self.scatter_rad):.2f}°"
        )


@dataclass(frozen=True)
class CommonShift:
    """A shift that all hips share, as that of the chassis' CoM.

    Parameters
    ----------
    com_b_m
        CoM of the chassis beside where it was taken to be, body axes, shape (3,), m.
    sd_m
        Of each axis, shape (3,), m.
    stands_out
        Whether hips that are placed as well as their prior says would hardly share so much.
    """

    com_b_m: FloatArray
    sd_m: FloatArray
    stands_out: bool


def common_shift(
    shift_b_m: FloatArray, mean_sd_m: FloatArray, hip_sd_m: float, com_sd_m: float
) -> CommonShift:
    """Part of the hips' shifts against the chassis' CoM that is the CoM's.

    With ``s_k = p_k − c``, ``p_k ~ N(0, σ_p²)`` and ``c ~ N(0, σ_c²)``, the CoM given the shifts is
    ``c = −Σ s_k / σ_p² / (K / σ_p² + 1 / σ_c²)``, with the variance
    ``1 / (K / σ_p² + 1 / σ_c²)`` and that of the mean shift.

    Parameters
    ----------
    shift_b_m
        Hips minus chassis CoM against the nominal geometry, body axes, shape (K, 3), m.
    mean_sd_m
        Of their mean, shape (3,), m.
    hip_sd_m, com_sd_m
        σ_p and σ_c.
    """
    legs = len(shift_b_m)
    precision = legs / hip_sd_m**2 + 1.0 / com_sd_m**2
    share = legs / hip_sd_m**2 / precision
    mean = shift_b_m.mean(axis=0)
    alone = hip_sd_m**2 / legs + mean_sd_m**2
    chi2 = float(np.sum(np.square(mean) / alone))
    sd = np.sqrt(1.0 / precision + share**2 * mean_sd_m**2)
    return CommonShift(-share * mean, np.asarray(sd), bool(chances.chi2_sf(chi2, 3) < COMMON_P))


MACHINED_SD_M = 0.001
"""How far hips of one robot lie from their drawing, each by itself, where nothing is wrong."""
ODD_P = 0.01


@dataclass(frozen=True)
class OddHip:
    """A hip that lies elsewhere than all others say.

    Parameters
    ----------
    leg
        Its number.
    shift_b_m, sd_m
        Against the mean shift of the others, body axes, shape (3,) each, m.
    """

    leg: int
    shift_b_m: FloatArray
    sd_m: FloatArray


def odd_hip(shift_b_m: FloatArray, covariance: FloatArray) -> OddHip | None:
    """The one hip whose shift is not that of the others, which agree; None where there is none.

    ``d_k = s_k − mean of the others`` holds nothing of the chassis' CoM. With C its covariance and
    what machining scatters, ``d C⁻¹ d ~ χ²(3)``; the largest of K counts K times.

    Parameters
    ----------
    shift_b_m
        Hips minus chassis CoM against the nominal geometry, body axes, shape (K, 3), m.
    covariance
        Of the same, hip by hip, shape (3 K, 3 K), m².
    """

    def contrasts(legs: list[int]) -> list[tuple[float, int, FloatArray, FloatArray]]:
        found = []
        for k in legs:
            along = np.zeros(len(shift_b_m))
            along[legs] = -1.0 / (len(legs) - 1)
            along[k] = 1.0
            each = np.kron(along, np.eye(3))
            apart = each @ covariance @ each.T + MACHINED_SD_M**2 * (along @ along) * np.eye(3)
            off = along @ shift_b_m
            found.append(
                (float(off @ np.linalg.solve(apart, off)), k, off, np.sqrt(np.diag(apart)))
            )
        return sorted(found, key=lambda one: -one[0])

    legs = list(range(len(shift_b_m)))
    if len(legs) < _LEAST_LEGS:
        return None
    chi2, odd, off, sd = contrasts(legs)[0]
    rest = contrasts([k for k in legs if k != odd])[0][0]
    alone = len(legs) * chances.chi2_sf(chi2, 3) < ODD_P
    agree = (len(legs) - 1) * chances.chi2_sf(rest, 3) > ODD_P
    return OddHip(odd, off, sd) if alone and agree else None


_LEAST_LEGS = 4


def common_turn(turn_b_rad: FloatArray) -> CommonTurn | None:
    """Mean turn of the mountings against their scatter.

    ``T² = K m̄ᵀ S⁻¹ m̄`` with S the covariance of the legs' roll and pitch about their mean;
    ``(K − 2) T² / (2 (K − 1)) ~ F(2, K − 2)`` where legs only scatter (Hotelling 1931). Yaw is left
    out: a level shows none.

    Parameters
    ----------
    turn_b_rad
        Rotation vector of each mounting error in body axes, ``R_bt = exp[turn] R_nominal``,
        shape (K, 3).

    Returns
    -------
    None of fewer than four legs, or where all are turned exactly alike by the model.
    """
    legs, tilt = turn_b_rad.shape[0], turn_b_rad[:, :2]
    if legs < 4:
        return None
    mean = tilt.mean(axis=0)
    scatter = np.cov(tilt, rowvar=False)
    if np.linalg.matrix_rank(scatter) < 2:
        return None
    t_squared = legs * float(mean @ np.linalg.solve(scatter, mean))
    p = float(chances.f_sf((legs - 2) * t_squared / (2 * (legs - 1)), 2, legs - 2))
    half = chances.t_ppf(0.975, legs - 1) * np.sqrt(np.diag(scatter) / legs)
    return CommonTurn(mean, np.asarray(half), float(np.sqrt(np.trace(scatter) / 2.0)), p)

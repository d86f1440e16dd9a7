"""What the two papers print, row by row.

Foot paper: "NAO CoP self-calibration". Hip paper: Wu & Revzen. Both in ``CITATION.cff``.
"""

from __future__ import annotations

FOOT = "NAO CoP self-calibration"
HIPS = "Wu & Revzen"

TABLE_3 = {"CoP": (0.1839, 0.0005, "m"), "vGRF": (5.298, 0.08, "N")}
"""RMSE before and after manual offline calibration."""

TABLES_4_TO_6 = {
    0.02: {"window": (0.0059, 0.4339), "static": (0.0108, 1.2949)},
    0.04: {"window": (0.0108, 0.5324), "static": (0.0166, 1.8646)},
    0.1: {"window": (0.0134, 1.0387), "static": (0.0199, 2.5220)},
}
"""Speed, m/s -> method -> CoP RMSE in m and vGRF RMSE in N, one walk each."""

MS_PER_UPDATE = 2.5

TABLE_I = {
    "full": (36, 12, 1580),
    "body_rotations": (21, 17, 1674),
    "translations": (18, 62, 2352),
    "single": (3, 105, 2546),
}
"""Model -> degrees of freedom, CV error, BIC; P = 543."""
POSES = 543

TABLE_II_SD = {
    "hl": ((0.03, 0.01, 0.01), (0.0002, 0.003, 0.003), 0.2),
    "ml": ((0.001, 0.001, 0.001), (0.0002, 0.0002, 0.0001), 0.2),
    "fl": ((0.01, 0.01, 0.003), (0.0001, 0.0005, 0.0004), 0.1),
    "hr": ((0.02, 0.004, 0.01), (0.0002, 0.0009, 0.001), 0.2),
    "mr": ((0.02, 0.001, 0.01), (0.0009, 0.0012, 0.001), 0.2),
    "fr": ((0.01, 0.001, 0.004), (0.0004, 0.001, 0.0007), 0.1),
}
"""Leg -> printed sd of force offsets (N), torque offsets (Nm) and leg weight (N)."""
HANGING_SD_N = 0.2
NAIVE_FORCE_SD_N, TORQUE_BIAS_NM = 5.0, 2.5

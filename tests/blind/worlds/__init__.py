"""The generators, one module per experiment; none imports footcal's core."""

from __future__ import annotations

from collections.abc import Mapping

from tests.blind.world import Maker
from tests.blind.worlds import hang, placements, pose, stand, walk, weights

WORLDS: Mapping[str, Maker] = {
    "weights": weights.MAKER,
    "placements": placements.MAKER,
    "stand": stand.MAKER,
    "walk": walk.MAKER,
    "hang": hang.MAKER,
    "pose": pose.MAKER,
}

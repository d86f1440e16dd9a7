"""A foreign physics world: robots, estimators and rigs that share nothing with `footcal_cli`.

No module here imports the product or the blind bench's generators. Everything is drawn from one
seed, and a seed is one robot: `walk(7)`, `stand(7)`, `weights(7)` show the same cells, `hang(7)`
and `poses(7)` the same legs. What an ordinary robot has and nobody calls a fault is always there:
quantised encoders, differentiated velocities, a millisecond of unknown stamp lag, a fifth of the
angular momentum missing, a centre of mass off by a millimetre, plates of 25 g under the cells,
soles that roll by millimetres, legs that accelerate while they turn, autocorrelated noise.

    from tests.foreign import hang, placements, poses, stand, walk, weights, write
    recorded = walk(seed)              # tables, recipe and truth, in memory
    recipe = write(recorded, folder)   # ... as files
"""

from tests.foreign.bench import placements, weights
from tests.foreign.biped import CELLS, Biped, draw_biped
from tests.foreign.files import Recorded, joined, write
from tests.foreign.legs import Hexapod, draw_hexapod, hang, poses
from tests.foreign.streams import Distort, stand, walk

__all__ = [
    "CELLS",
    "Biped",
    "Distort",
    "Hexapod",
    "Recorded",
    "draw_biped",
    "draw_hexapod",
    "hang",
    "joined",
    "placements",
    "poses",
    "stand",
    "walk",
    "weights",
    "write",
]

"""The feasible experiments, by id."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from footcal_cli.core.diagnosis import planned_bench as bench
from footcal_cli.core.diagnosis import planned_robot as robot
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects.body import MASS
from footcal_cli.core.effects.six_axis_beliefs import LEG_WEIGHT, ROBOT_WEIGHT
from footcal_cli.core.effects.transport import LAG
from footcal_cli.core.experiments import hang, placements, pose, stand, walk, weights
from footcal_cli.core.experiments.contract import Experiment
from footcal_cli.core.log import Log


@dataclass(frozen=True)
class Plan:
    """A feasible experiment.

    Parameters
    ----------
    id
        Its name in ``diagnosis.json``.
    experiment
        What `diagnose` judges the log by.
    words
        What to do, for the experimenter.
    minutes
        What one run takes, set-up included.
    blocks
        Blocks of evidence that one run gives.
    make
        The planned recordings: true loads, no noise, no effect.
    settles
        Effects that the experimenter takes out of the question with it: switched off, or measured
        by other means. The log is as the one before it, and is diagnosed without them.
    anew
        Whether a log is recorded at all; otherwise the one at hand is diagnosed again.
    """

    id: str
    experiment: Experiment
    words: str
    minutes: float
    blocks: int
    make: Callable[[Rig], tuple[Log, ...]]
    settles: tuple[str, ...] = ()
    anew: bool = True


_WEIGHTS, _WALK = weights.EXPERIMENT, walk.EXPERIMENT

PLANS: tuple[Plan, ...] = (
    Plan("up_down", _WEIGHTS, "weights up and down in eight steps on each cell, 5 s each",
         3.0, 1, bench.up_down),
    Plan("random_order", _WEIGHTS, "weights in random order on each cell, each twice, 10 s each",
         4.0, 1, bench.random_order),
    Plan("fine_ladder", _WEIGHTS, "weights up and down in 24 small steps on each cell, 5 s each",
         6.0, 1, bench.fine_ladder),
    Plan("push_pull", _WEIGHTS, "weights up and down in eight steps on each cell, then the same "
         "weights pulling at it", 8.0, 1, bench.push_pull),
    Plan("up_down_60s", _WEIGHTS, "weights up and down in eight steps on each cell, 60 s each",
         17.0, 1, bench.up_down_60s),
    Plan("hold_5min", _WEIGHTS, "the largest weight on each cell for 5 minutes, then 5 minutes "
         "unloaded", 11.0, 1, bench.hold_5min),
    Plan("ramps", _WEIGHTS, "on each cell a load that rises and falls slowly (1 min), then twice "
         "fast (3 s)", 4.0, 1, bench.ramps),
    Plan("taps", _WEIGHTS, "20 quick taps on each cell with the largest weight, read at 80 Hz",
         2.0, 1, bench.taps),
    Plan("warm_up", _WEIGHTS, "the largest weight on and off each cell every 20 s while it warms "
         "by 5 K, with a thermometer", 16.0, 1, bench.warm_up),
    Plan("holes", placements.EXPERIMENT, "five weights on the 18 holes of each foot",
         45.0, 18, bench.holes),
    Plan("stand_turned", stand.EXPERIMENT, "24 quiet stances of 4 s, toes turned 45° out and "
         "15° in by turns, on both feet and on one, at several heights, leaning this way and that",
         6.0, 24,
         robot.stand_turned),
    Plan("weigh_standing", stand.EXPERIMENT, "the robot as it stands on a scale, battery and "
         "cables included, its weight as mass_kg in the recipe, and the same log diagnosed again: "
         "what cells get wrong stays", 5.0, 24, robot.stand_turned,
         settles=(MASS.name,), anew=False),
    Plan("bounce", _WALK, "bouncing and swaying on both feet, three times 12 s with a tempo that "
         "rises from 0.5 to 4 Hz, hips going down by a fifth and up again every 4 s",
         2.0, 12, robot.bounce),
    Plan("turn_and_bounce", _WALK, "bouncing and swaying on both feet, three times 12 s facing "
         "each of four ways, toes turned 45° out and 15° in by turns, with a tempo that rises from "
         "0.5 to 4 Hz, hips going down by a fifth and up again every 4 s",
         6.0, 12, robot.turn_and_bounce),
    Plan("walk_turning", _WALK, "walking a full circle to the left, then one to the right",
         3.0, 12, robot.walk_turning),
    Plan("walk_squatting", _WALK, "walking a full circle each way in small quick steps (0.6 s), "
         "bobbing by 1 cm with each, hips going down by a third and up again every 2.5 s",
         4.0, 12, robot.walk_squatting),
    Plan("walk_slow_fast", _WALK, "walking 30 s with slow steps (1.2 s), then 30 s with fast ones "
         "(0.5 s)", 3.0, 12, robot.walk_slow_fast),
    Plan("walk_unsmoothed", _WALK, "the same walk with all smoothing of the body's stream "
         "switched off: a delay stays, a low-pass goes", 3.0, 12, robot.walk_straight,
         settles=(LAG.name,)),
    Plan("weigh_walking", _WALK, "the robot as it walked on a scale, battery and cables included, "
         "its weight as mass_kg in the recipe, and the same log diagnosed again: what cells get "
         "wrong stays", 5.0, 12, robot.walk_straight, settles=(MASS.name,), anew=False),
    Plan("hang", hang.EXPERIMENT, "hanging the robot in two opposite pairs of orientations, legs "
         "turning slowly", 30.0, 40, robot.hang),
    Plan("pose_tilted", pose.EXPERIMENT, "90 poses, some on three legs, on a board tilted by up "
         "to 15°, another way every time", 25.0, 15, robot.pose_tilted),
    Plan("pose_tripods", pose.EXPERIMENT, "90 poses on three legs in turn",
         20.0, 15, robot.pose_tripods),
    Plan("weigh_robot", pose.EXPERIMENT, "the whole robot on a scale, its weight as mass_kg in "
         "the recipe, and the same log diagnosed again: wrong weights of legs stay", 5.0, 15,
         robot.pose_tilted, settles=(ROBOT_WEIGHT.name,), anew=False),
    Plan("hang_again", pose.EXPERIMENT, "the robot hung again just as it stood in the poses, "
         "hang-calib once more, and the same log diagnosed again from there: a wrong weight of the "
         "robot stays", 30.0, 15, robot.pose_tilted, settles=(LEG_WEIGHT.name,), anew=False),
)  # fmt: skip

"""Which experiment next? A menu of feasible ones, judged by how far they push rivals apart.

Each plan is simulated: what an effect would do to the planned log at its fitted size, what of it
neither the refitted calibration nor the refitted rival can absorb, over the noise of this data.

The plans by id, and the kind of log that `diagnose` then reads:

``weights`` (ladders on each cell alone, several sessions)
    ``up_down`` eight steps up and down, 5 s each; ``random_order`` the same weights shuffled, each
    twice, 10 s; ``up_down_60s`` eight steps up and down, 60 s each; ``fine_ladder`` 24 steps up
    and down, 5 s each; ``push_pull`` eight steps up and down, then the same weights pulling;
    ``hold_5min`` the largest weight for 5 minutes, 5 minutes unloaded; ``ramps`` a slow load up
    and down (1 min) and two fast ones (3 s); ``taps`` 20 quick taps sampled at 80 Hz; ``warm_up``
    the largest weight on and off every 20 s while warming by 5 K.
``placements``
    ``holes`` one weight on 18 holes of each foot, at five sizes.
``stand``
    ``stand_turned`` 24 quiet stances of 4 s on both feet and on one, leaning, toes turned 45° out
    and 15° in by turns; ``weigh_standing`` the log at hand again, the robot's mass from a scale.
``walk`` (body and cells as streams)
    ``bounce`` on both feet, three times 12 s: bouncing and swaying, tempo rising from 0.5 to 4 Hz,
    hips down by 20 % and up again every 4 s; ``turn_and_bounce`` the same, three times facing each
    of four ways, the hips a little lower every time, toes 45° out and 15° in by turns;
    ``walk_turning`` walking a circle each way (30 s); ``walk_squatting`` the same in small steps
    of 0.6 s that bob by 1 cm each, hips down by 30 % of their height and up again every 2.5 s;
    ``walk_slow_fast`` 30 s with steps of 1.2 s, then of 0.5 s; ``walk_unsmoothed`` the walk at
    hand once more, smoothing of the body's stream switched off; ``weigh_walking`` the log at hand
    again, the robot's mass from a scale.
``hang``
    ``hang`` hanging in two opposite pairs of orientations, legs turning slowly.
``pose``
    ``pose_tilted`` poses with the body tilted up to 15° and turned; ``pose_tripods`` poses on
    three legs in turn; ``weigh_robot`` the log at hand again, the robot's weight from a scale;
    ``hang_again`` the log at hand again, the legs' weights from another hanging.

Five of them take an effect out of the question instead of making it look different: what is then
diagnosed, without that effect in the table, shows whether the others are still there.

What no log can show (a spirit level, a scale) has no id; the table's own advice stands then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from footcal_cli.core import chances
from footcal_cli.core.diagnosis.comparison import OF_ANY_ORDER
from footcal_cli.core.diagnosis.plans import PLANS, Plan
from footcal_cli.core.diagnosis.rehearsal import Comparison, Contender, Rehearsal, rehearsed
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.transport import DELAY
from footcal_cli.errors import UsageError

MOST_RUNS = 30
"""Runs beyond which an experiment does not tell two effects apart."""
LIKE = 0.92
"""|cos| from which two effects count as one, however little noise there is: what is left of one
beside the other, ``1 − cos²``, is no more than models of effects are wrong by."""
_FEWEST_BLOCKS = 10
_STRANGE = 2.0
_TRUST = 1.0 / 3.0
"""Share of a predicted separation that is counted on: what does not repeat between runs and is not
white takes the rest."""
_NOT_TOLD = 2.0
"""Separation that data have at most which could not tell two effects apart at α = 0.05."""


@dataclass(frozen=True)
class Prospect:
    """What an experiment would do for a set of rivals.

    Parameters
    ----------
    plan
        The experiment.
    cosine
        Largest |cos| between two rivals that are distinguished there; 0 where one of them hides.
    separation
        Smallest part that the other of two such rivals cannot absorb, over the noise of one run.
    repeats
        Runs for a power of 0.8 at α = 0.01.
    left
        Rivals that are left beside the true one, on average over which one that is.
    """

    plan: Plan
    cosine: float
    separation: float
    repeats: int
    left: float

    @property
    def minutes(self) -> float:
        """What all the runs take."""
        return self.repeats * self.plan.minutes


@dataclass(frozen=True)
class Menu:
    """The experiments judged for a set of rivals.

    Parameters
    ----------
    rivals
        The named effect, then those that explain as much.
    now
        How far the present data keep the nearest two apart; None without data.
    prospects
        Those that leave the fewest rivals first, then the least work; those that tell none apart
        are left out.
    """

    rivals: tuple[Contender, ...]
    now: Comparison | None
    prospects: tuple[Prospect, ...]

    @property
    def best(self) -> Prospect | None:
        """What to run next."""
        return self.prospects[0] if self.prospects else None


def menu_for(
    rivals: Sequence[Contender],
    table: Mapping[str, Effect],
    rig: Rig,
    at_hand: Rehearsal | None = None,
) -> Menu:
    """Judge every feasible plan for a set of rivals.

    Separations are predicted from white noise; the data at hand tell how optimistic that is where
    noise and not likeness kept them from telling the rivals apart.

    Parameters
    ----------
    rivals
        The named effect, then those that explain as much.
    table
        Effects by name.
    rig
        Robot, loads and noise.
    at_hand
        The present data, which could not tell.
    """
    now = _nearest(at_hand, rivals, table) if at_hand is not None else None
    share = _TRUST
    if now is not None and now.cosine < LIKE:
        share = min(_TRUST, _NOT_TOLD / max(now.separation, 1e-12))
    names = [r.signature.effect for r in rivals]
    found = []
    for plan in PLANS:
        kind = plan.experiment.name
        seen = any(kind in table[name].experiments for name in names)
        asked = not plan.settles or not set(plan.settles).isdisjoint(names)
        if kind not in rig.kinds or not seen or not asked:
            continue
        known = at_hand if plan.settles and at_hand is not None and at_hand.kind == kind else None
        try:
            there = known.with_settled(plan.settles) if known else rehearsed(plan, rig)
        except UsageError:  # this robot would fall over
            continue
        # what these data show is no prediction
        prospect = _prospect(plan, there, rivals, table, 1.0 if known else share)
        found += [prospect] if prospect is not None else []
    usual = at_hand.kind if at_hand is not None else ""
    found.sort(key=lambda p: (round(p.left, 2), _work(p, usual)))
    return Menu(tuple(rivals), now, tuple(found))


def _work(prospect: Prospect, usual: str) -> float:
    """Minutes; double where another kind of experiment brings effects not in question before."""
    return prospect.minutes * (1.0 if prospect.plan.experiment.name == usual else _STRANGE)


def _prospect(
    plan: Plan,
    there: Rehearsal,
    rivals: Sequence[Contender],
    table: Mapping[str, Effect],
    share: float,
) -> Prospect | None:
    """What a plan does for all pairs of rivals; None where it tells none apart.

    One that keeps a pair merely less alike is no help: none of those ever resolved it. A log
    that is diagnosed again is all there is.
    """
    most = MOST_RUNS if plan.anew else 1
    resolved = []
    for first, second in permutations(rivals, 2):
        if _same_in_any_order(first, second, plan.settles):
            continue
        pair = there.compared(first, second, table)
        repeats = repeats_for(share * pair.separation, plan.blocks)
        if repeats <= most and pair.cosine < LIKE:
            resolved.append((pair.cosine, share * pair.separation, repeats))
    if not resolved:
        return None
    return Prospect(
        plan=plan,
        cosine=max(cosine for cosine, _, _ in resolved),
        separation=min(separation for _, separation, _ in resolved),
        repeats=max(repeats for _, _, repeats in resolved),
        left=(len(rivals) * (len(rivals) - 1) - len(resolved)) / len(rivals),
    )


def _same_in_any_order(first: Contender, second: Contender, settled: Sequence[str]) -> bool:
    """A delay beside a low-pass: only the table's first order would be distinguished from it."""
    names = {first.signature.effect, second.signature.effect}.difference(settled)
    return DELAY.name in names and bool(names & OF_ANY_ORDER)


def _nearest(
    where: Rehearsal, rivals: Sequence[Contender], table: Mapping[str, Effect]
) -> Comparison:
    """The first contender against the one that comes nearest to it."""
    first, *others = rivals
    return max((where.compared(first, other, table) for other in others), key=lambda c: c.cosine)


def repeats_for(separation: float, blocks: int = _FEWEST_BLOCKS) -> int:
    """Runs whose pooled separation is found in 80 % at α = 1 %, and ten blocks together."""
    if separation <= 0:
        return 10**6
    needed = float(chances.norm_ppf(1 - 0.01 / 2) + chances.norm_ppf(0.8))
    fewest = int(np.ceil(_FEWEST_BLOCKS / blocks))
    return max(int(np.ceil((needed / separation) ** 2)), fewest)


def advice(effects: Sequence[Effect]) -> str:
    """The table's own words on what separates these effects."""
    words = dict.fromkeys(e.separates for e in effects if e.separates)
    return "; or ".join(words)

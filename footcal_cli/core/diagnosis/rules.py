"""Every threshold of a diagnosis in one frozen place; listed in each ``diagnosis.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

LEVEL_SHARE: Mapping[str, float] = MappingProxyType(
    {"bump": 0.3, "flexible": 0.3, "line": 0.1, "between": 0.1, "spell": 0.1, "curve": 0.1}
)
"""Share of the level of 'unknown' that each library-free test has; a true line or a calibration
that follows temperature is far beyond its share."""


@dataclass(frozen=True)
class Rules:
    """Thresholds; development seeds set them, sealed seeds are scored with them.

    Parameters
    ----------
    alpha_name
        Family-wise level of naming a cause; half each for effects seen within and between blocks.
    alpha_small
        Level from which a cause below the size that matters is named, and called small; at less
        it must remove `later_share` of the squared error.
    alpha_unknown
        Level of saying that something without a name is left.
    alpha_rival
        A gain counts, and a rival's loss is larger, if significant at this level; a rival's in
        hangings, a few of which tell causes apart, at `alpha_beside`.
    alpha_beside
        A rival is out if the best cause still adds something beside it at this level.
    alpha_form
        A name is not enough if its size changes with a recorded signal at this level.
    alpha_whole, alpha_left
        A refit leaves nothing that its look-alikes could explain where p is at least the first,
        and leaves something where p is below the second.
    alpha_curve
        The same as `alpha_left` among curves: all of them together are a curve of any form, so that
        one that leaves nothing to these is the cell's.
    rival_loss
        Share of the gain by which a rival of the same kind must do worse where none leaves nothing.
    other_form
        Share of the gain that a curve of the other class, smooth or with a knee, must do worse by:
        no knee is sharp and no smooth curve a parabola, so a smooth one has both its terms here.
        Nine even loads, scale and bias free: a sharp knee costs a parabola 6 % of its gain, a soft
        one ``s w tanh(x/w)`` 2–4 %; a cubic polynomial costs a sharp knee 2–7 % and an exponential
        below 0.4 %. Few loads tell less: with five a knee costs an exponential as little as 0.6 %.
    wrong_form
        The same where the best curve leaves something too (p < `alpha_left`).
    misfit_share
        Share of what the best one adds beside a rival of its kind (p < `alpha_left`) below which
        lies all that its kind could still explain beside the best one, where the rival is out.
    bend_share
        Share of a transducer's gain that the 95 % bound of a curve of that axis must stay below
        for the gain alone to be named.
    rival_share
        Share of the best cause's gain that makes another one a rival at all.
    look_alike, contender_share, most_contenders
        |cos| with the named cause and share of its gain from which another cause is refitted in
        full too; so many at most.
    smallest_gain
        Held-out share of the squared error an accepted effect must remove.
    second_share
        Share of what the causes before it have removed that a later one must remove; less may be
        what the first one's form gets wrong: no foreign form of an effect is nearer to the table's
        (POSTERIOR.md, form error). Beside what was only written down wrong, which has no form,
        `later_share`; `pair_share` where no form of the first does it (diagnosis/beyond.py).
    later_share
        Share of what all causes remove below which the first one is needed no longer beside later
        ones. Curves without a name that remove more beside the named causes (p < `alpha_form`) make
        them unknown, as do sizes of single cells held at zero that would remove more with a sign
        that their cause cannot have; linear mixtures beside
        linear names if those explain less than `share_form`, and so do other curves of an axis
        beside its named one.
    pair_share, share_pair, most_pairs
        The same as `later_share` of two causes looked for together, where one at a time ended
        unknown: so little is believed only where nothing is left beside both, and they explain at
        least `share_partly` of what can be explained, with rivals `share_pair`: a second cause must
        not mend the form of a set. So many pairs are tried. `pair_share` also of a later cause that
        acts on other sensors than those before it, whose form it cannot be.
    most_effects
        Effects accepted at most.
    most_tries
        Candidates refitted at most, the best first, until one stands.
    visible_floor
        Visible fraction below which an effect is not testable.
    alias
        |cos| of visible signatures from which two effects are one.
    same
        |cos| from which no comparison of losses separates two effects: models are never so exact.
    alike_together
        |cos| from which two effects named together are not believed: they may copy a third.
    share_named, share_partly, share_form
        Share of what can be explained that the named effects must explain: below `share_named`
        the verdict is unknown, below `share_partly` too if something that matters is left, and
        below `share_form` of what they and sizes that change explain if a size surely does.
    share_set
        The same, instead of the last two, where the answer is a set of rivals: which of their forms
        it is stays open anyway.
    share_apart
        Share that a set must explain for what it leaves in time (lines, spells) to be its form.
    fewest_blocks
        Blocks asked for.
    fewest_sessions
        Blocks that must know of a cause in one of several cells; one less where the selection is
        repeated without one of them.
    most_folds
        Folds in which the selection is repeated; neighbouring blocks are left out together beyond.
    between_share
        An effect with less than this share of its information within blocks is tested between
        blocks.
    power
        Power at which sizes that would have been found are stated.
    """

    alpha_name: float = 0.01
    alpha_small: float = 1e-4
    alpha_unknown: float = 0.02
    alpha_rival: float = 0.05
    alpha_beside: float = 0.01
    alpha_form: float = 0.01
    alpha_whole: float = 0.02
    alpha_left: float = 0.002
    alpha_curve: float = 0.01
    rival_loss: float = 0.15
    other_form: float = 0.01
    wrong_form: float = 0.3
    misfit_share: float = 0.5
    bend_share: float = 0.25
    rival_share: float = 0.3
    look_alike: float = 0.6
    contender_share: float = 0.5
    most_contenders: int = 6
    smallest_gain: float = 0.01
    second_share: float = 0.25
    later_share: float = 0.1
    pair_share: float = 0.02
    share_pair: float = 0.99
    most_pairs: int = 2
    most_effects: int = 4
    most_tries: int = 3
    visible_floor: float = 0.02
    alias: float = 0.95
    same: float = 0.99
    alike_together: float = 0.6
    share_named: float = 0.7
    share_partly: float = 0.97
    share_form: float = 0.97
    share_set: float = 0.9
    share_apart: float = 1.0
    fewest_blocks: int = 10
    fewest_sessions: float = 3.0
    most_folds: int = 12
    between_share: float = 0.3
    power: float = 0.8

    def sentence(self) -> str:
        """What decides, in short."""
        return (
            f"A cause is named if chance alone would give one in less than {self.alpha_name:.0%} "
            f"of all diagnoses, and if it removes {self.smallest_gain:.0%} of the squared error or "
            "more on data that it was not fitted to. Whether the residual then holds more than "
            f"noise is decided at {self.alpha_unknown:.0%}. Every threshold is in diagnosis.json, "
            "under rules."
        )

    def listed(self) -> str:
        """All thresholds by name in one line."""
        shares = {f"level_share_{name}": share for name, share in LEVEL_SHARE.items()}
        return "; ".join(f"{name} {value:g}" for name, value in {**asdict(self), **shares}.items())

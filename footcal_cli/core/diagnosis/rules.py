"""Every threshold of a diagnosis in one frozen place; printed in the footer of each report."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Rules:
    """Thresholds; development seeds set them, sealed seeds are scored with them.

    Parameters
    ----------
    alpha_name
        Family-wise level of naming a cause; half each for effects seen within and between blocks.
    alpha_unknown
        Level of saying that something without a name is left.
    alpha_rival
        A gain counts, and a rival's loss is larger, if significant at this level.
    alpha_beside
        A rival is out if the best cause still adds something beside it at this level.
    alpha_form
        A name is not enough if its size changes with a recorded signal at this level.
    rival_share
        Share of the best cause's gain that makes another one a rival at all.
    smallest_gain
        Held-out share of the squared error an accepted effect must remove.
    later_share
        Share of what the causes before it have removed that a later one must remove; less may be
        what the first one's form gets wrong.
    most_effects
        Effects accepted at most.
    visible_floor
        Visible fraction below which an effect is not testable.
    alias
        |cos| of visible signatures from which two effects are one.
    alike_together
        |cos| from which two effects named together are not believed: they may copy a third.
    share_named, share_partly, share_form
        Share of what can be explained that the named effects must explain: below `share_named`
        the verdict is unknown, below `share_partly` too if something is left, below `share_form`
        too if a named size is not the same everywhere.
    fewest_blocks
        Blocks asked for.
    most_folds
        Folds in which the selection is repeated; neighbouring blocks are left out together beyond.
    between_share
        An effect with less than this share of its information within blocks is tested between
        blocks.
    power
        Power at which sizes that would have been found are stated.
    """

    alpha_name: float = 0.01
    alpha_unknown: float = 0.02
    alpha_rival: float = 0.05
    alpha_beside: float = 0.01
    alpha_form: float = 0.01
    rival_share: float = 0.3
    smallest_gain: float = 0.01
    later_share: float = 0.1
    most_effects: int = 4
    visible_floor: float = 0.02
    alias: float = 0.95
    alike_together: float = 0.6
    share_named: float = 0.7
    share_partly: float = 0.97
    share_form: float = 0.97
    fewest_blocks: int = 10
    most_folds: int = 12
    between_share: float = 0.3
    power: float = 0.8

    def sentence(self) -> str:
        """All thresholds in one line."""
        return (
            f"α = {self.alpha_name:g} family-wise for a name, {self.alpha_unknown:g} for "
            f"'unknown'; rivals: at least {self.rival_share:.0%} of the gain, loss difference "
            f"p > {self.alpha_rival:g} and nothing to add beside it (p > {self.alpha_beside:g}); "
            f"smallest gain {self.smallest_gain:.0%}, of a later cause {self.later_share:.0%} of "
            f"the gain before it; at most {self.most_effects} effects; visible at least "
            f"{self.visible_floor:.0%}; alias at |cos| > {self.alias:g}; "
            f"named together at |cos| < {self.alike_together:g}; named share at least "
            f"{self.share_named:g} ({self.share_partly:g} with a leftover, {self.share_form:g} "
            f"where a size changes with a signal, p < {self.alpha_form:g}); "
            f"{self.fewest_blocks} blocks or more asked; selection repeated in at most "
            f"{self.most_folds} folds."
        )

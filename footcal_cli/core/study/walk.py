"""The papers' methods on one walk, next to the estimator with memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from footcal_cli.core.centroidal import Reference
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.comparison import ReplayedWalk
from footcal_cli.core.online.replay import Replayed
from footcal_cli.core.parameters import Estimates, Status
from footcal_cli.core.quality import Finding
from footcal_cli.core.study.sensitivity import Sensitivity, memory_sensitivity, window_sensitivity
from footcal_cli.core.study.window import WindowRule
from footcal_cli.core.study.windows import QUIET_S, GivenWeights, Windowed, run_windows


@dataclass(frozen=True)
class PaperMethods:
    """Those of ``window`` and ``static`` that ran on a walk.

    Parameters
    ----------
    asked
        Those that were asked for.
    rule
        Of the sliding window.
    windowed
        Method -> its weights, and the forces and CoP it makes; a method without weights is absent.
    """

    asked: tuple[str, ...]
    rule: WindowRule
    windowed: Mapping[str, Windowed]

    @classmethod
    def run(
        cls, log: Log, belief: Belief, asked: Sequence[str], rule: WindowRule, given: GivenWeights
    ) -> PaperMethods:
        """Run the methods that are asked for; `given` are weights that are not to be chosen."""
        return cls(tuple(asked), rule, run_windows(log, belief, asked, rule, given))

    @property
    def replayed(self) -> dict[str, Replayed]:
        """Forces and CoP of each."""
        return {method: one.replayed for method, one in self.windowed.items()}

    def findings(self) -> list[Finding]:
        """Methods that had no standing to take their weights from."""
        left_out = [method for method in self.asked if method not in self.windowed]
        if not left_out:
            return []
        return [
            Finding(
                "no_standing_start",
                "note",
                " and ".join(left_out),
                "not compared: their weights come from standing still, and this log starts "
                f"with less than {QUIET_S} s of it",
                "give force_weight and cop_weight, or record standing before the first step",
            )
        ]

    def estimates(self, method: str, belief: Belief) -> Estimates:
        """The last solution of a method; it has no covariance of its own."""
        last, c = self.windowed[method].replayed, len(belief.channels)
        return belief.estimates(
            last.gain[-1], last.bias_n[-1], belief.covariance, [Status.PRIOR_KEPT] * (2 * c)
        )

    def sensitivity(self, found: ReplayedWalk) -> list[tuple[str, Sensitivity]]:
        """RMSE of memory and of the window as each of their settings is scaled."""
        against: Replayed | Reference = found.reference
        if found.best_reference == "truth":
            against = found.replayed["true"]
        elif found.best_reference == "baseline":
            against = found.replayed["baseline"]
        ours = memory_sensitivity(
            found.memory, found.belief, against, min_force_n=found.min_force_n
        )
        curves = [("memory", s) for s in ours]
        if "window" in self.windowed:
            log, weights = found.merged.log, self.windowed["window"].weights
            paper = window_sensitivity(log, found.belief, weights, against, self.rule)
            curves += [("window", s) for s in paper]
        return curves

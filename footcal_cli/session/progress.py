"""How far a long step has come: count, rate and time left on a terminal, nothing in a pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console

Advance = Callable[[float], None]


@contextmanager
def bar(console: Console, step: str, unit: str, total: float | None) -> Iterator[Advance]:
    """Show a step's progress while it runs.

    Parameters
    ----------
    console
        Only a terminal shows anything.
    step, unit
        What is done, and what is counted where `step` does not say it.
    total
        How many there are; None where nobody knows, and then no time left is shown.

    Yields
    ------
    A function to be called with how many more are done
    """
    if not console.is_terminal or console.quiet:
        yield lambda _: None
        return
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
    from rich.progress import TimeRemainingColumn as TimeLeft
    from rich.text import Text

    class Count(ProgressColumn):
        """Done, of how many, and how many per second."""

        def render(self, task: Task) -> Text:
            known = "" if task.total is None else f" of {task.total:,.0f}"
            rate = "" if not task.speed else f", {task.speed:,.3g} per second"
            return Text(" ".join(f"{task.completed:,.0f}{known} {unit}".split()) + rate)

    columns = [TextColumn("{task.description}"), BarColumn(bar_width=30), Count()]
    left = [TextColumn("left"), TimeLeft()] if total is not None else []
    with Progress(*columns, *left, console=console, transient=True) as shown:
        task = shown.add_task(step, total=total)
        yield lambda done: shown.advance(task, done)

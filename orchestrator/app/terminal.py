"""What is shown of a running analysis: on a terminal bars, and a line of what is done; else now and then a line."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Timer
from time import monotonic
from typing import TYPE_CHECKING

from rich.console import Console

from orchestrator.app.progress import IncrementDone, StageBegun, StageDone
from orchestrator.basis.printed import as_lambda

if TYPE_CHECKING:
    from rich.progress import TaskID

WATCHED = "orchestrator.limit_analysis", "orchestrator.macroblocks.automatic"
"""loggers whose messages are progress, until the finite elements begin"""
QUIET = 5.0
"""s without a word, where there is no terminal"""


class Reporter:
    """Draws what the driver reports: a bar per pushover on a terminal that can, now and then a line elsewhere."""

    def __init__(self, console: Console, listens: bool = True) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        name, state = (TextColumn(f"{{task.{what}}}", markup=False) for what in ("description", "fields[state]"))
        columns = name, BarColumn(bar_width=10), state, TimeElapsedColumn(), TimeRemainingColumn()
        self._console = console
        self._draws = console.is_terminal and not console.is_dumb_terminal
        self._progress = Progress(*columns, console=console, transient=True, disable=not self._draws)
        self._tasks: dict[str, TaskID] = {}
        self._last_line = 0.0
        self._listener = _Listener(self.say)
        self._watched = WATCHED if listens else ()
        self._said: float | None = None
        """when the last line about limit analysis was printed, s"""

    def __enter__(self) -> Reporter:
        self._progress.start()
        for name in self._watched:
            logging.getLogger(name).addHandler(self._listener)
            logging.getLogger(name).setLevel(logging.INFO)
        return self

    def __exit__(self, *_: object) -> None:
        self._stop_listening()
        self._progress.stop()

    def say(self, text: str) -> None:
        """Show what limit analysis does: the first line at once, the next ones where they do not follow too soon."""
        if self._draws:
            self._draw_line("micro-LA", text)
        elif self._said is None or monotonic() - self._said > QUIET:
            self._console.print(f"micro-LA: {text}", soft_wrap=True)
            self._said = monotonic()

    def _draw_line(self, stage: str, text: str) -> None:
        if "" not in self._tasks:
            self._tasks[""] = self._progress.add_task(stage, total=None, state="")
        self._progress.update(self._tasks[""], description=stage, state=text, refresh=True)

    def _stop_listening(self) -> None:
        for name in self._watched:
            logging.getLogger(name).removeHandler(self._listener)
            logging.getLogger(name).setLevel(logging.NOTSET)
        self._remove_line()

    def _remove_line(self) -> None:
        task = self._tasks.pop("", None)
        if task is not None:
            self._progress.remove_task(task)

    def __call__(self, event: StageBegun | StageDone | IncrementDone) -> None:
        """Show what the driver reports."""
        if isinstance(event, StageBegun):
            self._remove_line()
            if self._draws:
                self._draw_line(event.stage, event.text)
            else:
                self._console.print(f"{event.stage}: {event.text} ...", soft_wrap=True)
        elif isinstance(event, StageDone):
            self._stop_listening()
            self._console.print(f"{event.stage}: {event.text} ({event.seconds:.1f} s)", soft_wrap=True)
            self._last_line = 0.0
        else:
            self._show(event)

    def _show(self, event: IncrementDone) -> None:
        increment = event.increment
        state = (
            f"{increment.number} {increment.phase}: λ {as_lambda(increment.load_multiplier)}, "
            f"{1e3 * increment.control_displacement:.2f} mm, {increment.iterations} it."
        )
        self._remove_line()
        if event.model not in self._tasks:
            self._tasks[event.model] = self._progress.add_task(f"{event.model} FE", total=1.0, state="")
        self._progress.update(self._tasks[event.model], completed=event.fraction, state=state)
        if not self._draws and event.seconds - self._last_line > QUIET:
            self._console.print(f"{event.model} FE: {state}, {event.seconds:.0f} s", soft_wrap=True)
            self._last_line = event.seconds


@contextmanager
def shown(console: Console, stage: str, text: str, patience: float = QUIET) -> Iterator[None]:
    """Show what is being done where it is no part of a run: on a terminal at once, elsewhere after `patience` (s)."""
    with Reporter(console, listens=False) as report:
        late = Timer(0.0 if console.is_terminal else patience, report, [StageBegun(stage, text)])
        late.start()
        try:
            yield
        finally:
            late.cancel()


class _Listener(logging.Handler):
    """Hands every message of the loggers it is added to over, from whatever thread it comes."""

    def __init__(self, say: Callable[[str], None]) -> None:
        super().__init__(logging.INFO)
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        self._say(record.getMessage())

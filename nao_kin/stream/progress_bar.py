"""How far a long run has come, for whoever sits in front of it: rows, rate, and the time that is left."""

from __future__ import annotations

import sys
import time
from types import TracebackType


class ProgressBar:
    """A bar on standard error, when it is wanted and standard error is a terminal; otherwise nothing.

    A context manager: the bar disappears at its end.
    """

    def __init__(self, wanted: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        console = Console(file=sys.stderr)
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[rows]}"),
            TimeRemainingColumn(),
            console=console,
            disable=not (wanted and console.is_terminal),
            transient=True,
        )
        self._task = self._bar.add_task("forward kinematics", total=None, rows="")
        self._first, self._start = 0, time.monotonic()

    def start(self, rows: int, fraction: float | None) -> None:
        """Begin behind `rows` that an earlier run has done."""
        self._first, self._start = rows, time.monotonic()
        self._bar.update(self._task, total=None if fraction is None else 1.0, completed=fraction or 0.0)

    def show(self, rows: int, fraction: float | None) -> None:
        """So many rows are done, which is this much of the source, if that is known."""
        if self._bar.disable:
            return
        rate = (rows - self._first) / max(1e-9, time.monotonic() - self._start)
        self._bar.update(self._task, completed=fraction or 0.0, rows=f"{rows:,} rows, {rate:,.0f}/s")

    def joining(self) -> None:
        """All rows are done; the parts are being joined."""
        self._bar.update(self._task, description="joining the parts", total=None)

    def __enter__(self) -> ProgressBar:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._bar.stop()

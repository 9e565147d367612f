"""Ctrl-C before a command has begun its work: one line and exit code 130, whatever is being imported just then.

An exception would not do: libraries that are interrupted while they are imported take it for one of their own.
"""

from __future__ import annotations

import os
import signal

LINE = b"interrupted\n"
EXIT_CODE = 130
"""what a shell gives a command that an interrupt has ended: 128 and the number of the signal"""


def end_at_once() -> None:
    """Let Ctrl-C end this process at once, unless whoever has started it wants it to be ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def end_in_order() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again: from here on something may be half-written."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(*_: object) -> None:
    os.write(2, LINE)
    os._exit(EXIT_CODE)

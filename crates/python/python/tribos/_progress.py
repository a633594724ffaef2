"""Progress of long work."""

from __future__ import annotations

import sys
import time
from typing import Callable, Optional, Union

Callback = Callable[[float, str], object]
Progress = Union[None, bool, Callback]


class _Line:
    """One line on standard error, redrawn."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.width = 0

    def __call__(self, share: float, what: str) -> None:
        bar = "█" * round(30 * share)
        seconds = time.monotonic() - self.began
        text = f"{what:<34} {bar:<30} {100 * share:3.0f} % {seconds:5.1f} s"
        self.width = len(text)
        print(f"\r{text}", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self.width:
            print(f"\r{' ' * self.width}\r", end="", file=sys.stderr, flush=True)


class Shown:
    """Context that turns ``progress=`` into a callback, and clears the line afterwards."""

    def __init__(self, progress: Progress) -> None:
        self.line = _Line() if progress is True else None
        self.callback: Optional[Callback] = self.line if self.line else (progress or None)  # type: ignore[assignment]

    def __enter__(self) -> Optional[Callback]:
        return self.callback

    def __exit__(self, *_: object) -> None:
        if self.line:
            self.line.close()

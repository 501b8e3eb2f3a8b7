"""`followspot`: the entry of the console script.

Exit codes: 0 done, 1 the run failed, 2 the input is wrong, 130 interrupted.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command. Ctrl-C ends it quietly, also while its modules are imported, which takes a moment."""
    try:
        _open_closed_streams()
        from followspot.cli.command_line import run

        return run(argv)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # again while threads end: at once, without a traceback
        print("\nfollowspot: interrupted", file=sys.stderr)
        return 130


def _open_closed_streams() -> None:
    """Open the null device for each standard stream that the caller has closed.

    Else a file of the run could get its number, and whatever a library prints would go into that file.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is not None:
            continue
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)  # as those of workers
        setattr(sys, name, Path(os.devnull).open(mode))  # noqa: SIM115  # open as long as the process


if __name__ == "__main__":
    sys.exit(main())

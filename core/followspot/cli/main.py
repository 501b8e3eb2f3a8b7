"""`followspot`: run one command of the command line, turn errors into text and an exit code.

Exit codes: 0 done, 1 the run failed, 2 the input is wrong.
"""

from __future__ import annotations

import argparse
import errno
import gc
import os
import select
import sys
import traceback
from collections.abc import Sequence
from io import TextIOWrapper
from pathlib import Path

from followspot.cli import completion
from followspot.cli.parser import build_parser
from followspot.errors import FollowspotError, InputError
from followspot.notes import show_notes

_OF_FILES = frozenset(
    {
        *(errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM),
        *(errno.EFBIG, errno.EIO),
        *(errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG),
    }
)
"""Errors of files and disks that a user can mend, whichever command meets them; they are no defects."""


def main(argv: Sequence[str] | None = None) -> int:
    """Entry of the console script."""
    _open_closed_streams()
    try:
        return _run(argv)
    except KeyboardInterrupt:
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


def _run(argv: Sequence[str] | None) -> int:
    """Read and run a command; its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # workers are the parallelism; same bits everywhere
    gc.set_threshold(20_000, 20)  # imports make no garbage: to look for it took 5 % of a short run
    if "_ARGCOMPLETE" in os.environ:
        completion.complete(build_parser())
    args = _parsed(sys.argv[1:] if argv is None else argv)
    if args is None:
        return 2
    if isinstance(sys.stdout, TextIOWrapper):  # a terminal without UTF-8, or a file name that is none
        sys.stdout.reconfigure(errors="backslashreplace")
    show_notes(not args.quiet)
    return _exit_code(args)


def _parsed(words: Sequence[str]) -> argparse.Namespace | None:
    """The command and its arguments; None if the words name no command, after help is printed.

    Raises SystemExit if an argument is wrong.
    """
    parser = build_parser(words)
    args, unknown = parser.parse_known_args(words)
    if not hasattr(args, "run_command"):
        parser.print_help()
        return None
    if unknown and not args.parser.took_more(args, unknown):
        args.parser.error(args.parser.unknown(unknown))
    return args


def _exit_code(args: argparse.Namespace) -> int:
    """Run a command, print the error that it raises if a user can mend it, and return the exit code."""
    try:
        return int(args.run_command(args))
    except InputError as error:
        _trace(args)
        print(error, file=sys.stderr)
        count = len(error.mistakes)
        print(f"\n{count} mistake{'s' * (count != 1)}, nothing was started", file=sys.stderr)
        return 2
    except FollowspotError as error:
        _trace(args)
        print(f"followspot: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        if not _reader_has_gone():
            raise
        sys.stderr.close()
        return 1
    except OSError as error:
        if error.errno not in _OF_FILES:
            raise
        _trace(args)
        print(f"followspot: {error.filename or 'the output'}: {error.strerror}", file=sys.stderr)
        return 1


def _reader_has_gone() -> bool:
    """Whether what is printed cannot be read any more, as behind `| head`."""
    output = select.poll()
    try:
        output.register(sys.stdout.fileno(), select.POLLOUT)
    except (OSError, ValueError):  # it is no file
        return False
    return any(event & select.POLLERR for _, event in output.poll(0))


def _trace(args: argparse.Namespace) -> None:
    if args.verbose:
        traceback.print_exc()


if __name__ == "__main__":
    sys.exit(main())

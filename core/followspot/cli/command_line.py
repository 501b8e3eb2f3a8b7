"""Run one command of the command line, turn errors into text and an exit code."""

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

from followspot.cli import completion
from followspot.cli.ending_signals import ending_as_on_ctrl_c
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


def run(argv: Sequence[str] | None) -> int:
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
    with ending_as_on_ctrl_c():
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
    """Whether standard output has no reader any more, for example behind `| head`."""
    output = select.poll()
    try:
        output.register(sys.stdout.fileno(), select.POLLOUT)
    except (OSError, ValueError):  # it is no file
        return False
    return any(event & select.POLLERR for _, event in output.poll(0))


def _trace(args: argparse.Namespace) -> None:
    if args.verbose:
        traceback.print_exc()

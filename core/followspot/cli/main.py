"""`followspot`: parse the command line, run one command, turn errors into text and an exit code.

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
from typing import Any

from followspot.cli import agent, attach, certs, check, completion, graph, move, plugins, router, run, swap
from followspot.errors import FollowspotError, InputError, did_you_mean
from followspot.notes import show_notes
from followspot.plugins.loaded_hooks import load_commands

CORE = (
    run.COMMAND,
    check.COMMAND,
    graph.COMMAND,
    plugins.COMMAND,
    agent.COMMAND,
    router.COMMAND,
    attach.COMMAND,
    *swap.COMMANDS,
    move.COMMAND,
    *certs.COMMANDS,
    completion.COMMAND,
)
"""Commands of the core, in the order of `followspot --help`."""

_OF_FILES = frozenset(
    {
        *(errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM),
        *(errno.EFBIG, errno.EIO),
        *(errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG),
    }
)
"""Errors of files and disks that a user can mend, whichever command meets them; they are no defects."""

_ABOUT = """Compose tracking graphs from stage plugins and run them in one process or many.

  followspot run graphs/glowballs.yaml          track glowing balls in a simulated room
  followspot check graphs/glowballs.yaml        find every mistake without starting anything
  followspot plugins balls.mean_shift           what a stage does, its ports and parameters
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Entry of the console script."""
    _open_closed_streams()
    try:
        return _obeyed(argv)
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


def _obeyed(argv: Sequence[str] | None) -> int:
    """Read and run a command; its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # workers are the parallelism; same bits everywhere
    gc.set_threshold(20_000, 20)  # imports make no garbage: to look for it took 5 % of a short run
    if "_ARGCOMPLETE" in os.environ:
        completion.complete(build_parser())
    words = sys.argv[1:] if argv is None else argv
    parser = build_parser(words)
    args, unknown = parser.parse_known_args(words)
    if not hasattr(args, "run_command"):
        parser.print_help()
        return 2
    if unknown and not args.parser.took_more(args, unknown):
        args.parser.error(args.parser.unknown(unknown))
    if isinstance(sys.stdout, TextIOWrapper):  # a terminal without UTF-8, or a file name that is none
        sys.stdout.reconfigure(errors="backslashreplace")
    show_notes(not args.quiet)
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


def build_parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """The parser with all commands of the core and of plugins.

    words: of the command line; commands that are not among them get no options, which saves 9 ms.
    """
    parser = _Parser(
        prog="followspot", description=_ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    found = (*CORE, *load_commands())
    groups: dict[str, argparse._SubParsersAction[_Parser]] = {}
    for command in found:
        home = commands
        if command.parent is not None:
            if command.parent not in groups:
                names = ", ".join(other.name for other in found if other.parent == command.parent)
                group = commands.add_parser(command.parent, help=f"commands: {names}")
                groups[command.parent] = group.add_subparsers(
                    title="commands", metavar="COMMAND", required=True
                )
            home = groups[command.parent]
        added = home.add_parser(
            command.name,
            help=command.help.partition("\n")[0],
            description=command.help,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        added.set_defaults(run_command=command.run, parser=added)
        if words is None or command.name in words:
            command.configure(added)
            _add_common_options(added)
    return parser


def _add_common_options(parser: argparse.ArgumentParser) -> None:
    """Add what every command takes."""
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress and no notes")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="all lines of a run's log; where an error comes from"
    )


def _trace(args: argparse.Namespace) -> None:
    if args.verbose:
        traceback.print_exc()


class _Parser(argparse.ArgumentParser):
    """Suggests the word that a wrong word may have meant."""

    def took_more(self, args: argparse.Namespace, words: Sequence[str]) -> bool:
        """Give words after an option to the argument that takes several: options may stand anywhere.

        Returns False if there is none, or if one of the words is an option.
        """
        found = next((one for one in self._get_positional_actions() if one.nargs == "+"), None)
        if found is None or any(word.startswith("-") for word in words):
            return False
        more = [self._get_value(found, word) for word in words]
        setattr(args, found.dest, [*getattr(args, found.dest), *more])
        return True

    def unknown(self, words: Sequence[str]) -> str:
        """The error message for arguments that no option takes."""
        options = [word.partition("=")[0] for word in words if word.startswith("-")]
        remedy = "; name a run by --run" if "--run" in self._option_string_actions else ""
        if options:
            remedy = f"; {did_you_mean(options[0], self._option_string_actions, 'options')}"
        return f"unrecognized arguments: {' '.join(words)}{remedy}"

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            remedy = did_you_mean(str(value), [str(choice) for choice in action.choices], "known")
            raise argparse.ArgumentError(action, f'there is no "{value}"; {remedy}')


class _Version(argparse.Action):
    """Reads the version only on request."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"followspot {version('followspot')}")
        parser.exit()


if __name__ == "__main__":
    sys.exit(main())

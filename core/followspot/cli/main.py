"""`followspot`: parse the command line, run one command, turn errors into text and an exit code.

Exit codes: 0 done, 1 the run failed, 2 the input is wrong.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from followspot.cli import agent, attach, certs, check, graph, move, plugins, router, run, swap
from followspot.errors import FollowspotError, InputError
from followspot.plugins.hooks import Command

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
)
"""Commands of the core, in the order of `followspot --help`."""

_ABOUT = """Compose tracking graphs from stage plugins and run them in one process or many.

  followspot run graphs/glowballs.yaml          track glowing balls in a simulated room
  followspot check graphs/glowballs.yaml        find every mistake without starting anything
  followspot plugins balls.mean_shift           what a stage does, its ports and parameters
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Entry of the console script."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # workers are the parallelism; same bits everywhere
    parser = build_parser()
    args = parser.parse_args(argv)
    if not hasattr(args, "run_command"):
        parser.print_help()
        return 2
    try:
        return int(args.run_command(args))
    except InputError as error:
        print(error, file=sys.stderr)
        count = len(error.mistakes)
        print(f"\n{count} mistake{'s' * (count != 1)}, nothing was started", file=sys.stderr)
        return 2
    except FollowspotError as error:
        print(f"followspot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nfollowspot: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 1


def build_parser() -> argparse.ArgumentParser:
    """The parser with all commands; those of plugins come through their hook."""
    parser = argparse.ArgumentParser(
        prog="followspot", description=_ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    groups: dict[str, argparse._SubParsersAction[argparse.ArgumentParser]] = {}
    for command in (*CORE, *_plugin_commands()):
        home = commands
        if command.parent is not None:
            if command.parent not in groups:
                group = commands.add_parser(command.parent, help=f"commands: {command.parent} ...")
                groups[command.parent] = group.add_subparsers(
                    title="commands", metavar="COMMAND", required=True
                )
            home = groups[command.parent]
        _add(home, command)
    return parser


def _add(home: argparse._SubParsersAction[argparse.ArgumentParser], command: Command) -> None:
    parser = home.add_parser(
        command.name,
        help=command.help.splitlines()[0],
        description=command.help,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.configure(parser)
    parser.set_defaults(run_command=command.run)


def _plugin_commands() -> Sequence[Command]:
    from followspot.plugins.hooks import load_commands

    return load_commands()


class _Version(argparse.Action):
    """Reads the version only when asked."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"followspot {version('followspot')}")
        parser.exit()


if __name__ == "__main__":
    sys.exit(main())

"""The parser of the command line, with the commands of the core and of all packages."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from followspot.cli import agent, attach, certs, check, completion, graph, move, plugins, router, run, swap
from followspot.errors import did_you_mean
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

_ABOUT = """Compose tracking graphs from stage plugins and run them in one process or many.

  followspot run graphs/glowballs.yaml          track glowing balls in a simulated room
  followspot check graphs/glowballs.yaml        find every mistake without starting anything
  followspot plugins balls.mean_shift           what a stage does, its ports and parameters
"""

_NEEDED = {
    "DIR": "path",
    "RUN|DIR": "path",
    "ENDPOINT": "endpoint",
    "NAME": "name",
    "STAGE[.PORT],...": "list of ports",
}
"""What an argument needs, by its metavar. An empty word would mean the present folder, or the default."""


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
    """Add the options that every command takes."""
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress and no notes")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="all lines of a run's log; where an error comes from"
    )


class _Parser(argparse.ArgumentParser):
    """Suggests the word that a wrong word may have meant, and refuses two values of one option."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._given: dict[argparse.Action, list[tuple[Any, str]]] = {}
        """The options of the command line that is read: the values of each, and their words."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Read a command line; see `argparse`."""
        self._given.clear()
        return super().parse_known_args(args, namespace)

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

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """The value of one word. Raises ArgumentError if it is empty, and for a second value of an option."""
        if not arg_string and arg_string is not action.default and (kind := _needed(action)):
            raise argparse.ArgumentError(action, f"the {kind} is empty")
        value = super()._get_value(action, arg_string)
        if action.option_strings and isinstance(action, argparse._StoreAction):
            self._take(action, value, arg_string)
        return value

    def _take(self, action: argparse.Action, value: Any, word: str) -> None:
        """Keep a word of an option with its value. Raises ArgumentError if it ends another value of it."""
        size = 1 if action.nargs is None else action.nargs
        if not isinstance(size, int):
            return
        given = self._given.setdefault(action, [])
        given.append((value, word))
        if len(given) < 2 * size:
            return
        (before, written), (after, again) = (
            tuple(zip(*half, strict=True)) for half in (given[:size], given[size:])
        )
        if before != after and written != again:
            first, second = (f"{' '.join(words):.80}" for words in (written, again))
            raise argparse.ArgumentError(action, f"given twice, as {first} and as {second}")
        del given[size:]

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            remedy = did_you_mean(str(value), [str(choice) for choice in action.choices], "known")
            raise argparse.ArgumentError(action, f'there is no "{value}"; {remedy}')


def _needed(action: argparse.Action) -> str:
    """What an argument needs if nothing else looks at an empty word, "" for other arguments."""
    return "path" if action.type is Path else _NEEDED.get(str(action.metavar), "")


class _Version(argparse.Action):
    """Reads the version only on request."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"followspot {version('followspot')}")
        parser.exit()

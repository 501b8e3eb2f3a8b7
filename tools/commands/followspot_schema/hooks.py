"""Joins `followspot schema` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.cli.graph_options import add_plugin_option
from followspot.plugins.hooks import Command, hookimpl

KINDS = ("graph", "room", "placement")


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `schema`."""
    return [Command("schema", _configure, _run)]


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("kind", choices=KINDS, help="which files it describes")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write it there, not to the terminal"
    )
    add_plugin_option(parser, "describe the stages of a Python file, too; repeatable")


def _run(args: argparse.Namespace) -> int:
    """JSON Schema of graph, room or placement files, with every installed stage and its parameters

    Editors complete and explain what a file may say. With the YAML extension of VS Code, write the schemas
    once and name the one that applies in the first line of a file:

    Examples:
      followspot schema graph -o graph.schema.json
      # yaml-language-server: $schema=graph.schema.json

    `followspot check` finds more than a schema can: ports, types, cycles, files that do not exist.
    """
    import json

    from followspot.plugins.registry import use_plugin_files
    from followspot_schema.documents import document

    use_plugin_files(args.plugin_files)
    text = json.dumps(document(args.kind), indent=2) + "\n"
    if args.output is None:
        print(text, end="")
    else:
        args.output.write_text(text, encoding="utf-8")
    return 0

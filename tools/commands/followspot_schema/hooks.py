"""The command `followspot schema`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.cli.graph_options import add_plugin_option
from followspot.errors import writing
from followspot.plugins.hooks import Command, hookimpl

KINDS = ("graph", "room", "placement")


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `schema`."""
    return [Command("schema", _configure, _run)]


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("kind", choices=KINDS, help="kind of the files that the schema describes")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="file to write (default: standard output)"
    )
    add_plugin_option(parser, "also describe the stages of a Python file; repeatable")


def _run(args: argparse.Namespace) -> int:
    """Print the JSON Schema of graph, room or placement files, with all installed stages.

    With a schema, editors complete and explain the keys of a file. For the YAML extension of VS Code, write
    the schemas once, and name the schema of a file in its first line, as below. `followspot check` finds more
    mistakes than a schema can: ports, types, cycles, files that do not exist.

    Examples:
      followspot schema graph -o graph.schema.json
      # yaml-language-server: $schema=graph.schema.json
    """
    import json

    from followspot.plugins.registry import use_plugin_files
    from followspot_schema.documents import document

    use_plugin_files(args.plugin_files)
    text = json.dumps(document(args.kind), indent=2) + "\n"
    if args.output is None:
        print(text, end="")
    else:
        with writing(args.output):
            args.output.write_text(text, encoding="utf-8")
    return 0

"""`followspot plugins`: list installed stages with their state, or show ports and parameters of one."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from followspot.cli.graph_options import add_plugin_option
from followspot.plugins.hooks import Command

if TYPE_CHECKING:
    from followspot.plugins.catalogue import StageEntry

_WIDEST_RANGE = 60
"""Characters of a range in a table; the names of many choices are listed below it."""
KINDS = {
    "plain": "",
    "joined": " (joined: one per edge)",
    "latest": " (latest: sampled, never fires)",
    "nearest": " (nearest in time, never fires)",
    "window": " (window: all since the last firing, never fires)",
}
"""Text about each kind of input."""
GIVING = {
    "one": "",
    "several": " (several for one firing)",
    "later": " (deferred: comes later, in order)",
    "lagged": " (lagged: for earlier firings)",
}
"""Text about each kind of output."""


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "name", nargs="?", metavar="PLUGIN.STAGE", help="one stage, for example balls.mean_shift"
    )
    add_plugin_option(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")


def _run(args: argparse.Namespace) -> int:
    """List the installed stages and their state, or show the ports and parameters of one stage.

    Examples:
      followspot plugins
      followspot plugins balls.mean_shift
    """
    from followspot.plugins.description import describe
    from followspot.plugins.registry import PluginError, file_stages, load_stage, stage_names

    files = file_stages(args.plugin_files)
    broken = [entry for entry in files if entry.state == "broken"]
    if args.name is None:
        _list(files, as_json=args.json)
        return 1 if broken else 0
    if broken and args.name not in stage_names():
        raise PluginError(broken[0].problem)
    described = describe(args.name, load_stage(args.name))
    print(json.dumps(described, indent=2) if args.json else _page(described))
    return 0


def _list(files: Sequence[StageEntry], *, as_json: bool) -> None:
    """Print the installed stages and hooks, and the stages of one-file plugins."""
    from followspot.plugins.catalogue import catalogue
    from followspot.plugins.loaded_hooks import load_hooks
    from followspot.plugins.registry import examined
    from followspot.tables.terminal import table

    stages = [*(examined(entry) for entry in catalogue().values()), *files]
    hooks = load_hooks().modules
    if as_json:
        print(json.dumps({"stages": [vars(s) for s in stages], "hooks": [vars(h) for h in hooks]}, indent=2))
    else:
        rows = [(s.name, s.distribution, s.state, s.problem) for s in stages]
        rows += [(f"({h.name})", h.distribution, "broken" if h.problem else "ok", h.problem) for h in hooks]
        print(table(("stage (hooks)", "distribution", "state", "problem"), rows))


def _page(described: dict[str, Any]) -> str:
    from followspot.tables.terminal import table

    lines = [described["name"], "", described["description"], ""]
    for port in described["inputs"]:
        optional = "" if port["required"] else ", optional"
        lines.append(f"  in   {port['name']}: {port['type']}{KINDS[port['kind']]}{optional}")
    gives = GIVING[described["gives"]]
    lines += [f"  out  {port['name']}: {port['type']}{gives}" for port in described["outputs"]]
    if described["parameters"]:
        rows = [
            (p["name"], "required" if p["required"] else str(p["default"]), _short(p["range"]), p["unit"])
            for p in described["parameters"]
        ]
        lines += ["", table(("parameter", "default", "range", "unit"), rows), ""]
        for p in described["parameters"]:
            choices = (
                "" if _short(p["range"]) == p["range"] else f"; one of {p['range'].replace(' | ', ', ')}"
            )
            lines.append(f"  {p['name']}: {p['description']}{choices}")
    return "\n".join([*lines, "", f"  {described['example']}"])


def _short(told: str) -> str:
    """The range of a parameter for a column; many choices are counted there and listed below the table."""
    return told if len(told) <= _WIDEST_RANGE else f"{told.count(' | ') + 1} choices"


COMMAND = Command("plugins", _configure, _run)

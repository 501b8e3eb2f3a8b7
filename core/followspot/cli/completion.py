"""`followspot completion`: the shell completes commands, files, stages, parameters, runs and ports.

An argument's metavar says what it takes, so that arguments of plugins are completed, too.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, cast

from followspot.errors import FollowspotError
from followspot.plugins.hooks import Command

if TYPE_CHECKING:
    from followspot.graph.plan import Plan

_SHELLS = ("bash", "zsh", "fish")


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell that asks for completions, and exit; return if no shell asks."""
    import argcomplete

    argcomplete.autocomplete(parser, default_completer=cast(Any, _completions))  # it need not be a class


def _completions(
    prefix: str, action: argparse.Action, parsed_args: argparse.Namespace, **_: Any
) -> Collection[str] | Mapping[str, str]:
    """Words that the argument can take, with their meanings if these are known."""
    from argcomplete.completers import FilesCompleter

    metavar = action.metavar if isinstance(action.metavar, str) else ""
    if metavar in _FILES:
        return FilesCompleter(_FILES[metavar], directories=True)(prefix)
    if metavar not in _WORDS:
        return FilesCompleter()(prefix)
    with suppress(FollowspotError):  # a graph with mistakes, or no run: nothing to offer
        return dict(_WORDS[metavar](prefix, parsed_args))
    return ()


Words = Iterator[tuple[str, str]]
"""Words, and what each means."""


def _runs(prefix: str = "", args: argparse.Namespace | None = None) -> Words:
    from followspot.library.handle import runs_here

    for run in runs_here():
        yield run.graph, f"run {run.run[:8]}, process {run.pid}"


def _stages(prefix: str, args: argparse.Namespace) -> Words:
    """Installed stages."""
    from followspot.plugins.catalogue import catalogue

    return ((name, entry.distribution) for name, entry in catalogue().items())


def _plans(args: argparse.Namespace) -> Iterator[Plan]:
    """The plan of the graph file that the command line names, or of the runs. Raises FollowspotError."""
    from followspot.graph.compile import compile_graph
    from followspot.library.handle import runs_here

    said = vars(args)
    if "run" in said:
        runs = runs_here()
        yield from (run.plan() for run in [run for run in runs if run.graph == said["run"]] or runs)
    elif graph := said.get("graph") or next(iter(said.get("graphs") or ()), None):
        yield compile_graph(graph, room=said.get("room"), plugin_files=said["plugin_files"])


def _stages_of_plan(prefix: str, args: argparse.Namespace) -> Words:
    """Instances, and the sub-graphs that hold them."""
    from followspot.graph.names import enclosing

    for plan in _plans(args):
        groups = [enclosing(stage.group)[:-1] for stage in plan.stages]
        yield from ((name, "sub-graph") for name in dict.fromkeys(name for found in groups for name in found))
        yield from ((stage.name, stage.uses) for stage in plan.stages)


def _ports(prefix: str, args: argparse.Namespace) -> Words:
    from followspot.graph.output_ports import output_ports, port_names

    begun = prefix[: prefix.rfind(",") + 1]
    for plan in _plans(args):
        for port, kind in output_ports(plan).items():
            yield from ((begun + name, kind.__name__) for name in port_names(port, plan.offered))
        yield from ((begun + name, ", ".join(ports)) for name, ports in plan.offered.items())


def _parameters(prefix: str, args: argparse.Namespace) -> Words:
    """STAGE.PARAMETER=, and after STAGE.uses= an installed stage."""
    from followspot.plugins.registry import load_stage

    key, equals, _ = prefix.partition("=")
    if equals:
        for name, distribution in _stages(prefix, args) if key.endswith(".uses") else ():
            yield f"{key}={name}", distribution
        return
    stages = [stage for plan in _plans(args) for stage in plan.stages]
    named = {name: stage.uses for stage in stages for name in (stage.group, stage.name)}
    for stage, used in named.items():
        if not stage.startswith(key.partition(".")[0]):
            continue
        yield f"{stage}.uses=", f"instead of {used}"
        for name, info in load_stage(used).Params.model_fields.items():
            yield f"{stage}.{name}=", info.description or ""


def _changes(prefix: str, args: argparse.Namespace) -> Words:
    """STAGE=USES or STAGE.PARAMETER=VALUE."""
    key, equals, _ = prefix.partition("=")
    if equals and "." not in key:
        for name, distribution in _stages(prefix, args):
            yield f"{key}={name}", distribution
        return
    for word, meaning in _parameters(prefix, args):
        yield word.replace(".uses=", "="), meaning


def _places(prefix: str, args: argparse.Namespace) -> Words:
    """Workers of the run."""
    for plan in _plans(args):
        yield from ((worker.name, worker.host or "this host") for worker in plan.workers)


_FILES = {"GRAPH": ("yaml", "yml"), "FILE.mcap": ("mcap",), "FILE.py": ("py",), "ROOM.yaml": ("yaml", "yml")}
"""Endings of the files that an argument takes, by its metavar."""
_WORDS: Mapping[str, Callable[[str, argparse.Namespace], Words]] = {
    "RUN": _runs,
    "RUN|DIR": _runs,
    "STAGE": _stages_of_plan,
    "PLUGIN.STAGE": _stages,
    "STAGE[.PORT]": _ports,
    "STAGE[.PORT],...": _ports,
    "STAGE.KEY=VALUE": _parameters,
    "STAGE.KEY=VALUES": _parameters,
    "STAGE=USES|STAGE.PARAMETER=VALUE": _changes,
    "PLACE": _places,
}
"""The functions that give the words which an argument takes, by its metavar."""


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=_SHELLS, help="the shell that reads the script")


def _run(args: argparse.Namespace) -> int:
    """Print the script with which a shell completes commands, graphs, stages, parameters, runs and ports.

    Examples:
      eval "$(followspot completion bash)"                      in ~/.bashrc
      eval "$(followspot completion zsh)"                       in ~/.zshrc
      followspot completion fish | source                       in ~/.config/fish/config.fish
    """
    from argcomplete.shell_integration import shellcode

    print(shellcode(["followspot"], shell=args.shell))
    return 0


COMMAND = Command("completion", _configure, _run)

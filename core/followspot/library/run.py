"""Checks a graph, or starts it, from a script or a notebook."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

from followspot.errors import InputError, Mistake
from followspot.graph.arrange import EdgeChoice
from followspot.graph.plan import Plan
from followspot.library.flight_recorder import recorder_of
from followspot.library.graph import Graph
from followspot.library.keep_options import Keep
from followspot.library.keywords import errors_in_python, in_python
from followspot.library.own_run import OwnRun
from followspot.library.plan_settings import PATH, PlanSettings, as_tuple, check_type, plan_of, whole_number
from followspot.library.subscription_sinks import SubscriptionSinks
from followspot.operator.launch import prepared_run, unused_agents
from followspot.operator.output_folder import existing_folder
from followspot.transport.zenoh.network import Network
from followspot.worker.wiring import RunOptions


def check(
    graph: str | Path | Graph,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002  # as --set is called
    ports: str | Sequence[str] = (),
    **options: Unpack[PlanSettings],
) -> list[Mistake]:
    """Every mistake in a graph, its room and its placement, as data; nothing is started.

    A graph without mistakes can still have warnings (`Mistake.warning`): what can never come to anything.
    set, ports, room, cameras, placement, seed, plugin_files, edges: as `run` takes them.
    """
    try:
        ports = as_tuple("ports", ports)
        plan = plan_of(graph, set, ports, **options)
        SubscriptionSinks(plan, ports).end()
        return list(plan.warnings)
    except InputError as error:
        return list(error.mistakes)


def run(
    graph: str | Path | Graph,
    *,
    room: str | Path | None = None,
    cameras: str | Sequence[str] = (),
    set: Mapping[str, Any] | None = None,  # noqa: A002  # as --set is called
    placement: str | Path | None = None,
    ports: str | Sequence[str] = (),
    out: str | Path | None = None,
    frames: int | None = None,
    seed: int | None = None,
    plugin_files: str | Path | Sequence[str | Path] = (),
    edges: EdgeChoice = "auto",
    restart: bool = False,
    network: Network = Network(),
    media: str | Path = ".",
    keep: str | float | Keep | None = None,
) -> OwnRun:
    """Start a graph and return a handle on the run; use it in a ``with`` block, which ends the run.

    graph: its file, or one that the script composed; room: room file in place of the graph's; cameras: those
    that take part, all by default; set: parameters and stages, ``{"fuse.uses": "balls.mean"}``; seed: of
    simulations and random numbers; plugin_files: Python files whose stages the graph uses.

    ports: STAGE.PORT, one or several, of subscriptions from the first message on: ``run["track.tracks"]``
    iterates over them. In a replay a slow loop holds up the run; in a live run it misses messages, which are
    counted. out: folder for outputs, by default a new one below ``runs``; frames: number after which each
    source ends; keep: time that a flight recorder holds (``"30s"``) and `OwnRun.mark` saves.

    placement: "camera", "stage", "auto:REPORT.json" or a placement file, by default one worker; edges:
    "reference", "ring" or "zenoh" forces the kind of every edge; restart: whether workers that die are
    restarted in a replay, too; network: leads to agents on other hosts; media: local folder whose files
    agents have below their --media.

    Issues the warnings of `check` in Python. Raises InputError with every mistake.
    """
    ports = as_tuple("ports", ports)
    check_type("out", out, PATH | None, "give the path of a folder")
    check_type("media", media, PATH, "give the path of a folder")
    check_type("network", network, Network, "give followspot.Network(connect=...)")
    frames = whole_number("frames", frames, 1, "give a whole number from 1, or nothing for all")
    plan = plan_of(
        graph,
        set,
        ports,
        room=room,
        cameras=cameras,
        placement=placement,
        seed=seed,
        plugin_files=plugin_files,
        edges=edges,
    )
    _warn(plan, network)
    sinks = SubscriptionSinks(plan, ports)
    recorder = recorder_of(sinks.plan, keep)
    folder = _output_folder(out, plan)
    run = prepared_run(
        sinks.plan,
        RunOptions(folder, frames),
        network=network,
        media=Path(media),
        restart=restart,
        in_process=sinks.in_process,
    )
    return OwnRun(sinks, run, folder, recorder)


def _warn(plan: Plan, network: Network) -> None:
    """Issue the warnings of a plan in Python, at the line that called `run`."""
    for mistake in plan.warnings:
        warnings.warn(str(mistake), stacklevel=3)
    for text in unused_agents(plan, network.connect):
        warnings.warn(in_python(text), stacklevel=3)


def _output_folder(out: str | Path | None, plan: Plan) -> Path:
    """The folder for outputs, which exists now. Raises FollowspotError."""
    with errors_in_python():
        return existing_folder(Path(out or Path("runs") / f"{plan.graph}-{time.strftime('%Y%m%d-%H%M%S')}"))

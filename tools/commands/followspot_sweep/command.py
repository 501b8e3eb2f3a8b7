"""`followspot sweep`: check every value, run every point, print the table."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from followspot.cli.graph_options import output_folder
from followspot.cli.trial_options import check_rooms, trial_plan
from followspot.errors import InputError
from followspot_sweep.axes import Axis, Point, points, read_axes
from followspot_sweep.fingerprint import fingerprint_of
from followspot_sweep.no_effect import axes_without_effect
from followspot_sweep.plot import draw
from followspot_sweep.run_all import run_all
from followspot_sweep.table import best, rows, text, write
from followspot_sweep.trial import Task, folder_name


@dataclass(frozen=True)
class Scene:
    """A room as a folder and a table call it, its file, and the fingerprint of the graph in this room."""

    name: str
    room: str | None
    fingerprint: str


def sweep(args: argparse.Namespace) -> int:
    """Run every point in every room; print a table or JSON. Returns the exit code."""
    axes = read_axes(args.overrides)
    scenes = _scenes(args, axes)
    out = output_folder(args.out, "sweep")
    tasks = [
        Task(s.name, point, _command(args, s.room, point), out / s.name / folder_name(point), s.fingerprint)
        for s in scenes
        for point in points(axes)
    ]
    results = run_all(tasks, args.jobs, quiet=args.quiet)
    found = rows(results)
    written = write(found, out)
    drawn = draw(found, axes, args.best, out)
    without_effect = axes_without_effect(results, axes)
    if args.json:
        whole = {
            "rows": found,
            "best": best(found, args.best),
            "without_effect": without_effect,
            "out": str(out),
        }
        print(json.dumps(whole))
    else:
        said = "".join(
            f"\n{name} changes nothing: all its values gave the same files" for name in without_effect
        )
        print(f"{text(found, axes, args.best)}\n{said}\n{written}\n{drawn}\noutputs: {out}")
    failed = [result for result in results if result.error]
    for result in failed:
        print(f"followspot: {result.task.folder.name}: {result.error}", file=sys.stderr)
    return 1 if failed else 0


def _scenes(args: argparse.Namespace, axes: Sequence[Axis]) -> list[Scene]:
    """The rooms. Raises InputError: every value of every axis is planned once, before anything runs."""
    mistakes = check_rooms(args.rooms)
    scenes = []
    for room in args.rooms or [None]:
        found = (trial_plan(args.graph, room, _overrides(point), args, mistakes) for point in _trials(axes))
        plans = [plan for plan in found if plan is not None]
        if plans:
            name = Path(room).stem if room else plans[0].room.name
            scenes.append(Scene(name, room, fingerprint_of(plans)))
    if mistakes:
        raise InputError(list(dict.fromkeys(mistakes)))
    return scenes


def _trials(axes: Sequence[Axis]) -> Iterator[Point]:
    """Points that together have every value of every axis."""
    first = {axis.name: axis.values[0] for axis in axes}
    yield tuple(first.items())
    for axis in axes:
        for value in axis.values[1:]:
            yield tuple((first | {axis.name: value}).items())


def _overrides(point: Point) -> list[str]:
    return [f"{name}={value}" for name, value in point]


def _command(args: argparse.Namespace, room: str | None, point: Point) -> tuple[str, ...]:
    """Arguments of `followspot`."""
    words = ["run", args.graph]
    words += ["--room", room] if room else []
    for override in _overrides(point):
        words += ["--set", override]
    for file in args.plugin_files:
        words += ["--plugin", file]
    words += ["--seed", str(args.seed)] if args.seed is not None else []
    words += ["--frames", str(args.frames)] if args.frames else []
    return tuple(words)

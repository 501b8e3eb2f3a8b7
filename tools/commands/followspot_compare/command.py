"""`followspot compare`: plan everything, run everything, print the comparison."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from followspot.cli.graph_options import output_folder
from followspot.cli.progress import ProgressBar
from followspot.cli.trial_options import check_rooms, trial_plan
from followspot.cli.trial_outputs import same_outputs
from followspot.errors import FollowspotError, InputError, Mistake, writing
from followspot.graph.override import not_undone
from followspot.graph.plan import Plan
from followspot.library.execute import RunOptions, room_truth
from followspot.operating_system.standard_output import printed_to_stderr
from followspot_accuracy import PoseTruthTable, TruthTable
from followspot_compare.plot import draw
from followspot_compare.report import Comparison, data, text
from followspot_compare.trial import Trial, run_trial
from followspot_compare.variants import Variant, read_variants


@dataclass(frozen=True)
class Scene:
    """A room as a folder and a table call it, and the plan of every variant in it."""

    name: str
    plans: tuple[Plan, ...]


def compare(args: argparse.Namespace) -> int:
    """Run every variant in every room; print tables or JSON, draw plots. Returns the exit code.

    Raises FollowspotError if a run fails, KeyboardInterrupt on Ctrl-C, after what was compared until then is
    written.
    """
    variants = read_variants(args.graphs, args.variants)
    scenes = plan_scenes(variants, args)
    out = output_folder(args.out, "compare")
    trials: list[Trial] = []
    try:
        for scene in scenes:
            with printed_to_stderr(args.json):
                trials.extend(run_scene(scene, variants, out, args))
    except (FollowspotError, KeyboardInterrupt) as ended:
        if known := comparable(trials, len(variants)):
            try:
                print_report(Comparison(known), out, args)
            except FollowspotError as error:  # a full disk, for example, of which the run failed, too
                if isinstance(ended, FollowspotError):
                    raise FollowspotError(f"{ended}\n{error}") from None
                print(f"followspot: {error}", file=sys.stderr)
        raise
    print_report(Comparison(tuple(trials), unchanged(variants, scenes, out)), out, args)
    return 0


def comparable(trials: Sequence[Trial], variants: int) -> tuple[Trial, ...]:
    """The trials of rooms in which all variants ran; without such a room, those of the only one begun."""
    ran = Counter(trial.room for trial in trials)
    complete = [trial for trial in trials if ran[trial.room] == variants]
    return tuple(complete or trials)


def print_report(comparison: Comparison, out: Path, args: argparse.Namespace) -> None:
    """Print tables or JSON, write the JSON, draw plots."""
    print(json.dumps(data(comparison)) if args.json else text(comparison))
    file = out / "compare.json"
    with writing(file):
        file.write_text(json.dumps(data(comparison)), encoding="utf-8")
    pictures = draw(comparison, out)
    if not args.json:
        print("\n" + (f"{pictures}\n" if pictures else "") + f"outputs: {out}")


def unchanged(variants: Sequence[Variant], scenes: Sequence[Scene], out: Path) -> tuple[str, ...]:
    """The variants that wrote the same files as the first one in every room."""
    first, *others = (variant.name for variant in variants)
    folders = [out / scene.name for scene in scenes]
    return tuple(name for name in others if all(same_outputs(f / first, f / name) for f in folders))


def plan_scenes(variants: Sequence[Variant], args: argparse.Namespace) -> tuple[Scene, ...]:
    """The plans of every variant in every room. Raises InputError with the mistakes of all of them."""
    mistakes = check_rooms(args.rooms)
    rooms = args.rooms or [None]
    scenes = []
    for room in rooms:
        found = (
            trial_plan(
                v.graph, room, [*not_undone(args.overrides, v.overrides), *v.overrides], args, mistakes
            )
            for v in variants
        )
        plans = [plan for plan in found if plan is not None]
        if len(plans) == len(variants):
            _check_room(plans, room, mistakes)
            scenes.append(Scene(Path(room).stem if room else plans[0].room.name, tuple(plans)))
    if mistakes:
        raise InputError(list(dict.fromkeys(mistakes)))
    return tuple(scenes)


def _check_room(plans: Sequence[Plan], room: str | None, mistakes: list[Mistake]) -> None:
    """Note a room without truth, and graphs that name different rooms."""
    first = plans[0].room
    if first.truth is None:
        remedy = "compare needs truth: a recording imported with its truth, or a simulated room"
        mistakes.append(Mistake(None, f"room {room or first.name} knows no ground truth", remedy))
    for plan in plans:
        if (plan.room.name, plan.room.truth) != (first.name, first.truth):
            text = f"the graphs name different rooms: {first.name} and {plan.room.name}"
            mistakes.append(Mistake(None, text, "give one for all with --room FILE"))


def run_scene(
    scene: Scene, variants: Sequence[Variant], out: Path, args: argparse.Namespace
) -> Iterator[Trial]:
    """Every variant in one room, one after the other so that they do not slow each other down."""
    truth: TruthTable | PoseTruthTable | None = None
    for variant, plan in zip(variants, scene.plans, strict=True):
        truth = truth or room_truth(plan, args.frames)
        assert truth is not None  # checked with the plans
        if not args.quiet:
            print(f"{scene.name}: {variant.name}", file=sys.stderr, flush=True)
        folder = out / scene.name / variant.name
        folder.mkdir(parents=True, exist_ok=True)
        with closing(ProgressBar()) as bar:
            options = RunOptions(folder, args.frames)
            show = None if args.quiet else bar.show
            trial = run_trial(variant.name, scene.name, plan, truth, options, show)
        yield trial

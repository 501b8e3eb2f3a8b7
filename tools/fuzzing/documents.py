"""Targets: graph, room and placement files that say extreme things, through all of `check` and `graph`.

What `check` accepts is run for a frame in the target `runs`: what fails there with a traceback is a mistake
that `check` should have found.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import shutil
import tempfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.graph import show
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.operator.launch import run_plan
from followspot.plugins.registry import load_stage
from followspot.worker.wiring import RunOptions
from fuzzing.target import Target
from fuzzing.trees import Pairs, Raw, Tree, emit, extreme, extreme_like, mutated, read_tree

ROOT = Path(__file__).parents[2]
LONGEST_S = 2.0
"""Seconds of work for a document."""
MOST_MB = 300
"""MB for the process that checks documents, including all modules that it has loaded."""
_COMMAND = 30
"""One of so many documents goes through the command itself."""


@dataclass(frozen=True)
class Files:
    """The texts of a graph, its room and its placement."""

    graph: str
    room: str
    placement: str


def _texts(*names: str) -> list[str]:
    return [(ROOT / "graphs" / name).read_text() for name in names]


_GLOWBALLS, _PERSONS = _texts("glowballs.yaml", "person_room.yaml")
_ROOMS = dict(
    zip((_GLOWBALLS, _PERSONS), _texts("rooms/simulated.yaml", "rooms/simulated_persons.yaml"), strict=True)
)
_CAMERAS = {_GLOWBALLS: "cam0", _PERSONS: "left"}
_SWAPS = (
    "balls.mean",
    "balls.bundle",
    "filters.kalman_filterpy",
    "sim.targets",
    "sinks.udp_json",
    "persons.hog",
)


def graph_values_target() -> Target:
    """Graphs that say extreme things."""
    return _target(lambda rng: _files(rng, graph=True))


def room_values_target() -> Target:
    """Rooms that say extreme things."""
    return _target(lambda rng: _files(rng, room=True))


def placement_values_target() -> Target:
    """Placements that say extreme things."""
    return _target(lambda rng: _files(rng, placement=True))


def runs_target() -> Target:
    """Graphs and rooms that say extreme things, run for a frame if `check` accepts them."""
    return Target(
        lambda rng: _files(rng, graph=rng.random() < 0.6, room=rng.random() < 0.6), _run, (FollowspotError,)
    )


def _target(make: Callable[[random.Random], Files]) -> Target:
    for number in range(8):  # modules imported for good files are not the memory of a bad one
        _check(_files(random.Random(number)))
    return Target(make, _check, (FollowspotError,), LONGEST_S, MOST_MB)


def _files(rng: random.Random, *, graph: bool = False, room: bool = False, placement: bool = False) -> Files:
    """A good set of files, some of them mutated."""
    good = rng.choice((_GLOWBALLS, _PERSONS))
    trees = read_tree(good), read_tree(_ROOMS[good]), _placement(good, rng)
    trees[0].put("room", "room.yaml")
    ways = (graph, _graph_way), (room, _room_way), (placement, _placement_way)
    return Files(
        *(emit(mutated(t, rng, way) if chosen else t) for t, (chosen, way) in zip(trees, ways, strict=True))
    )


def _placement(good: str, rng: random.Random) -> Tree:
    stages = [name for name, _ in read_tree(good).get("stages").items]
    left = Pairs([("host", "pc-left"), ("cameras", [_CAMERAS[good]])])
    right = Pairs([("stages", rng.sample(stages, 2))])
    return Pairs([("placement", "two"), ("workers", Pairs([("left", left), ("right", right)]))])


def _graph_way(tree: Tree, rng: random.Random) -> None:
    """A parameter, a key of a stage, of an edge or of the graph gets an extreme value."""
    stages = tree.get("stages")
    if not isinstance(stages, Pairs) or not stages.items:
        return
    _, stage = rng.choice(stages.items)
    if not isinstance(stage, Pairs):
        return
    way = rng.randrange(6)
    if way <= 2:
        uses = stage.get("uses")
        _parameter(stage, uses if uses != "room.source" else "sim.camera", rng)
    elif way == 3:
        key = rng.choice(("uses", "each", "tolerance", "deadline", "on_error", "in", "with"))
        stage.put(key, rng.choice((*_SWAPS, "room.source")) if key == "uses" else extreme(rng))
    elif way == 4 and isinstance(stage.get("in"), Pairs) and stage.get("in").items:
        inputs = stage.get("in")
        port, _ = rng.choice(inputs.items)
        feed = Pairs([("from", rng.choice(stages.items)[0])])
        feed.put(rng.choice(("delay", "depth", "codec", "policy", "from")), extreme(rng))
        inputs.put(port, rng.choice((feed, rng.choice(stages.items)[0], extreme(rng))))
    else:
        key = rng.choice(("seed", "extends", "params", "inputs", "outputs", "room", "graph"))
        tree.put(key, rng.choice(([Raw('"graph.yaml"')], Pairs([("x", extreme(rng))]), extreme(rng))))


def _room_way(tree: Tree, rng: random.Random) -> None:
    """A number of a camera, a plane or a target, or a parameter of a source gets an extreme value."""
    cameras = tree.get("cameras")
    if not isinstance(cameras, Pairs) or not cameras.items:
        return
    camera = rng.choice(cameras.items)[1]
    way = rng.randrange(5)
    if way <= 1 and isinstance(camera, Pairs) and camera.items:
        key = rng.choice((*(key for key, _ in camera.items), "host", "clock_offset", "model"))
        camera.put(key, extreme_like(camera.get(key), rng))
    elif way <= 3 and isinstance(camera, Pairs):
        key, value = rng.choice((("source", camera.get("source")), ("truth", tree.get("truth"))))
        if isinstance(value, Pairs):
            alike = _parameter(value, value.get("uses"), rng)
            if alike is not None and rng.random() < 0.7:  # the same for all cameras, as a room requires
                for _, other in cameras.items:
                    if isinstance(other, Pairs) and isinstance(other.get("source"), Pairs):
                        _with(other.get("source")).put(*alike)
                if isinstance(tree.get("truth"), Pairs):
                    _with(tree.get("truth")).put(*alike)
    else:
        section = tree.get(rng.choice(("planes", "targets")))
        if isinstance(section, Pairs) and section.items:
            name, value = rng.choice(section.items)
            if isinstance(value, Pairs) and value.items:
                key, inner = rng.choice(value.items)
                value.put(key, extreme_like(inner, rng))
            else:
                section.put(name, extreme_like(value, rng))


def _placement_way(tree: Tree, rng: random.Random) -> None:
    """A worker has another host, camera or stage."""
    workers = tree.get("workers")
    if isinstance(workers, Pairs) and workers.items and isinstance(workers.items[0][1], Pairs):
        workers.items[0][1].put(
            rng.choice(("host", "cameras", "stages")), rng.choice((extreme(rng), [extreme(rng)]))
        )


def _with(holder: Pairs) -> Pairs:
    """The parameters of a stage, added if there are none."""
    if not isinstance(holder.get("with"), Pairs):
        holder.put("with", Pairs([]))
    found: Pairs = holder.get("with")
    return found


def _parameter(holder: Pairs, uses: Any, rng: random.Random) -> tuple[str, Tree] | None:
    """Give a parameter that the stage has an extreme value; the parameter and the value."""
    try:
        fields = load_stage(uses).Params.model_fields
    except (FollowspotError, AttributeError, TypeError):
        return None
    if not fields:
        return None
    name = rng.choice(list(fields))
    found = name, extreme_like(fields[name].get_default(call_default_factory=True), rng)
    _with(holder).put(*found)
    return found


def _written(files: Files) -> Path:
    """A folder with the files."""
    folder = Path(tempfile.mkdtemp(prefix="followspot-fuzz-"))
    for name, text in vars(files).items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8", errors="surrogatepass")
    return folder


def _check(files: Files) -> object:
    """Plan the files and show the plan in every form. Raises FollowspotError, which was shown."""
    folder = _written(files)
    try:
        placement = str(folder / "placement.yaml")
        if zlib.crc32(repr(files).encode("utf-8", "replace")) % _COMMAND == 0:
            _command(folder)
        try:
            plan = compile_graph(folder / "graph.yaml", placement=placement)
        except FollowspotError as error:
            str(error).encode()
            raise
        return _shown(plan)
    finally:
        shutil.rmtree(folder)


def _shown(plan: Plan) -> Plan:
    for form in (show.text, show.mermaid, show.svg):
        form(plan).encode()
    data = json.loads(json.dumps(plan_to_data(plan), allow_nan=False))
    if plan_to_data(plan_from_data(data)) != data:
        raise AssertionError("the plan is another one when it has been sent")
    return plan


def _command(folder: Path) -> None:
    """The commands end with 0 or 2 and print no traceback."""
    said = io.StringIO()
    files = [str(folder / "graph.yaml"), "--placement", str(folder / "placement.yaml")]
    for words in (["check", *files], ["check", "--strict", "--json", *files], ["graph", *files]):
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = main(words)
        if code not in (0, 2) or "Traceback" in said.getvalue():
            raise AssertionError(f"{words[0]} ended with {code}: {said.getvalue()[-300:]}")


def _run(files: Files) -> object:
    """Run the files for a frame. Raises FollowspotError if refused, AssertionError if the run fails."""
    folder = _written(files)
    try:
        plan = _shown(compile_graph(folder / "graph.yaml"))
        if any(stage.live for stage in plan.stages):
            return plan  # it would open a device, or wait for one
        report = run_plan(plan, RunOptions(folder / "out", frames=1))
        if any("Traceback" in error for error in report.errors):
            raise AssertionError(report.errors[0][-400:])
        return report
    finally:
        shutil.rmtree(folder)

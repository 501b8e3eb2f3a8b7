"""Targets: graph, room and placement files that say extreme things, through all of `check` and `graph`.

What `check` accepts is run for a frame in the target `runs`: what fails there with a traceback is a mistake
that `check` should have found.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.drawing.svg import svg
from followspot.graph.drawing.text import mermaid, text
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.operator.launch import run_plan
from followspot.plugins.registry import load_stage
from followspot.worker.wiring import RunOptions
from fuzzing.target import Target
from fuzzing.trees import Raw, Tree, broken_tree, emit, extreme, extreme_like, unlikely

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
    trees = {**yaml.safe_load(good), "room": "room.yaml"}, yaml.safe_load(_ROOMS[good]), _placement(good, rng)
    ways = (graph, _graph_way), (room, _room_way), (placement, _placement_way)
    return Files(
        *(emit(_mutated(t, rng, way) if chosen else t) for t, (chosen, way) in zip(trees, ways, strict=True))
    )


def _mutated(tree: Tree, rng: random.Random, more: Callable[[Tree, random.Random], None]) -> Tree:
    """The tree, changed in one to four ways; more: one that suits the kind of document."""
    for _ in range(rng.choice((1, 1, 1, 1, 2, 4))):
        if rng.random() < 0.7 and isinstance(tree, dict):
            with contextlib.suppress(AttributeError, IndexError, KeyError, TypeError):  # changed before
                more(tree, rng)
        else:
            tree = broken_tree(tree, rng, unlikely)
    return tree


def _placement(good: str, rng: random.Random) -> Tree:
    stages = list(yaml.safe_load(good)["stages"])
    left, right = {"host": "pc-left", "cameras": [_CAMERAS[good]]}, {"stages": rng.sample(stages, 2)}
    return {"placement": "two", "workers": {"left": left, "right": right}}


def _graph_way(tree: Tree, rng: random.Random) -> None:
    """A parameter, a key of a stage, of an edge or of the graph gets an extreme value."""
    names = list(tree["stages"])
    stage = tree["stages"][rng.choice(names)]
    way = rng.randrange(6)
    if way <= 2:
        uses = stage.get("uses")
        _parameter(stage, uses if uses != "room.source" else "sim.camera", rng)
    elif way == 3:
        key = rng.choice(
            ("uses", "each", "optional", "tolerance", "deadline", "depth", "on_error", "in", "with")
        )
        stage[key] = rng.choice((*_SWAPS, "room.source")) if key == "uses" else extreme(rng)
    elif way == 4 and stage.get("in"):
        option = rng.choice(("delay", "depth", "codec", "policy", "from"))
        feed = {"from": rng.choice(names), option: extreme(rng)}
        stage["in"][rng.choice(list(stage["in"]))] = rng.choice((feed, rng.choice(names), extreme(rng)))
    else:
        key = rng.choice(("seed", "vars", "include", "extends", "graph", "room"))
        tree[key] = rng.choice(([Raw('"graph.yaml"')], {"x": extreme(rng)}, extreme(rng)))


def _room_way(tree: Tree, rng: random.Random) -> None:
    """A camera, a sensor, a plane, a target, a tag, a tune or a parameter gets an extreme value."""
    cameras = tree["cameras"]
    camera = cameras[rng.choice(list(cameras))]
    way = rng.randrange(7)
    if way <= 1:
        key = rng.choice((*camera, "host", "clock_offset", "model"))
        camera[key] = extreme_like(camera.get(key), rng)
    elif way <= 3:
        use = rng.choice((camera["source"], tree["truth"]))
        alike = _parameter(use, use["uses"], rng)
        if alike is not None and rng.random() < 0.7:  # the same for all cameras, as a room requires
            for other in (*(camera["source"] for camera in cameras.values()), tree["truth"]):
                other.setdefault("with", {}).update([alike])
    elif way == 4:
        holder = rng.choice((camera, rng.choice(list(tree.get("targets", cameras).values()))))
        holder["tags"] = rng.choice(({"zone": extreme(rng)}, {"zone": ["a", extreme(rng)]}, extreme(rng)))
        mount = rng.choice(({"camera": extreme(rng)}, {"target": extreme(rng)}, extreme(rng)))
        imu = {"kind": "imu", "rate": 1000, "mount": mount, "source": camera["source"], "tags": {"zone": "a"}}
        tree["sensors"] = rng.choice(({"imu": imu}, {"imu": {**imu, "rate": extreme(rng)}}, extreme(rng)))
    elif way == 5:
        key = rng.choice(("balls.color_blobs.similarity", "track.fade_time", "color/cam0.x", extreme(rng)))
        tree["tune"] = rng.choice(({str(key): extreme(rng)}, {str(key): 0.5}, extreme(rng)))
    else:
        section = tree[rng.choice(("planes", "targets"))]
        holder, name = section, rng.choice(list(section))
        if isinstance(section[name], dict):
            holder, name = section[name], rng.choice(list(section[name]))
        holder[name] = extreme_like(holder[name], rng)


def _placement_way(tree: Tree, rng: random.Random) -> None:
    """A worker has another host, camera or stage."""
    worker = tree["workers"]["left"]
    worker[rng.choice(("host", "cameras", "stages"))] = rng.choice((extreme(rng), [extreme(rng)]))


def _parameter(holder: Tree, uses: Any, rng: random.Random) -> tuple[str, Tree] | None:
    """Give a parameter that the stage has an extreme value; the parameter and the value."""
    try:
        fields = load_stage(uses).Params.model_fields
    except (FollowspotError, AttributeError, TypeError):
        return None
    if not fields:
        return None
    name = rng.choice(list(fields))
    found = name, extreme_like(fields[name].get_default(call_default_factory=True), rng)
    holder.setdefault("with", {}).update([found])
    return found


@contextlib.contextmanager
def _written(files: Files) -> Iterator[Path]:
    """A folder with the files."""
    with TemporaryFolder("fuzz") as folder:
        for name, content in vars(files).items():
            (folder.path / f"{name}.yaml").write_text(content, encoding="utf-8", errors="surrogatepass")
        yield folder.path


def _check(files: Files) -> object:
    """Plan the files and show the plan in every form. Raises FollowspotError, which was shown."""
    with _written(files) as folder:
        placement = str(folder / "placement.yaml")
        if zlib.crc32(repr(files).encode("utf-8", "replace")) % _COMMAND == 0:
            _command(folder)
        try:
            plan = compile_graph(folder / "graph.yaml", placement=placement)
        except FollowspotError as error:
            str(error).encode()
            raise
        return _shown(plan)


def _shown(plan: Plan) -> Plan:
    for form in (text, mermaid, svg):
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
    with _written(files) as folder:
        plan = _shown(compile_graph(folder / "graph.yaml"))
        if any(stage.live for stage in plan.stages):
            return plan  # it would open a device, or wait for one
        report = run_plan(plan, RunOptions(folder / "out", frames=1))
        if any("Traceback" in error for error in report.errors):
            raise AssertionError(report.errors[0][-400:])
        return report

"""A graph that is composed in Python instead of a file."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from followspot.errors import FollowspotError, InputError, Mistake, Place
from followspot.graph.compile import compile_graph
from followspot.graph.compose.graph_file import input_names
from followspot.graph.declaration import ROOM_SOURCE
from followspot.graph.drawing.svg import svg
from followspot.graph.plan import Plan
from followspot.library.arguments import PortOf, StageOf, inputs_and_params, refuse_fed
from followspot.plugins.registry import load_stage, offer_stage
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.yaml.node import dump


class Graph:
    """A graph under construction; `run` and `check` take it in place of a file.

    ::

        graph = fs.Graph("mine", room="rooms/simulated.yaml")
        camera = graph.add("camera", "room.source", each="cameras")
        color = graph.add("color", "balls.color_blobs", each="cameras[kind=color]", frame=camera)
        graph.save("mine.yaml")
    """

    def __init__(self, name: str, *, room: str | Path | None = None, seed: int | None = None) -> None:
        """room: a room file, relative to the present folder; seed: of all random numbers."""
        self.name = name
        self.room = None if room is None else Path(room)
        self.seed = seed
        self.stages: dict[str, dict[str, Any]] = {}

    def add(
        self,
        name: str,
        uses: str | Path | type[Stage],
        /,
        *,
        each: str | None = None,
        on_error: Literal["fail", "skip", "restart"] | None = None,
        tolerance: float | None = None,
        deadline: float | None = None,
        depth: int | None = None,
        concurrency: int | None = None,
        **arguments: Any,
    ) -> StageOf:
        """Add a stage, or a graph file as a sub-graph.

        uses: the plugin stage, or a class of this process, which can run in this process only, or a graph
        file (.yaml), relative to the present folder, whose interface names the arguments; each: the
        cameras that the stage fans out over, for example ``cameras[kind=color]``; arguments: inputs (a stage,
        a port of one, or a list of them) and parameters, by name. tolerance, deadline: s; depth: of a
        live source; concurrency: of a stage with deferred outputs. Raises FollowspotError if the stage is not
        known, or the name is taken.
        """
        if name in self.stages:
            raise FollowspotError(f'stage "{name}" is there already')
        policies = {
            "on_error": on_error,
            "tolerance": tolerance,
            "deadline": deadline,
            "depth": depth,
            "concurrency": concurrency,
        }
        refuse_fed({"each": each, **policies})
        if isinstance(uses, Path) or (isinstance(uses, str) and uses.endswith((".yaml", ".yml"))):
            if any(value is not None for value in policies.values()):
                raise FollowspotError(f'sub-graph "{name}" has no policies of its own: its stages have')
            return self._add_file(name, Path(uses), each, arguments)
        used = uses if isinstance(uses, str) else offer_stage(uses)
        inputs = set() if used == ROOM_SOURCE else _inputs(load_stage(used), arguments)
        feeds, params = inputs_and_params(name, arguments, inputs)
        entry = {"uses": used, "each": each, "in": feeds or None, "with": params or None, **policies}
        self.stages[name] = {key: value for key, value in entry.items() if value is not None}
        return StageOf(name)

    def _add_file(self, name: str, file: Path, each: str | None, arguments: dict[str, Any]) -> StageOf:
        """Add a sub-graph. cameras among the arguments: a selector of cameras. Raises InputError."""
        cameras = arguments.pop("cameras", None)
        feeds, params = inputs_and_params(name, arguments, input_names(file))
        entry = {
            "graph": str(file.absolute()),
            "cameras": cameras,
            "each": each,
            "in": feeds or None,
            "with": params or None,
        }
        self.stages[name] = {key: value for key, value in entry.items() if value is not None}
        return StageOf(name)

    def port(self, name: str) -> PortOf:
        """A port of a stage that may be added later: ``graph.port("track.forecast").delayed(1)``."""
        stage, _, port = name.partition(".")
        return PortOf(stage, port)

    def to_yaml(self, room: Path | None = None) -> str:
        """The text of the graph file; room: path of the room file in it, by default the given one."""
        named = self.room if room is None else room
        data: dict[str, Any] = {"graph": self.name}
        data |= {} if named is None else {"room": str(named)}
        data |= {} if self.seed is None else {"seed": self.seed}
        return dump({**data, "stages": self.stages})

    def save(self, path: str | Path) -> Path:
        """Write the graph file, with a relative path to the room if it lies below. Raises OSError."""
        target = Path(path)
        room = self.room and self.room.absolute()
        if room is not None and room.is_relative_to(target.absolute().parent):
            room = room.relative_to(target.absolute().parent)
        target.write_text(self.to_yaml(room), encoding="utf-8")
        return target

    def plan(self, **options: Any) -> Plan:
        """The plan; options: as `followspot.graph.compile.compile_graph`. Raises InputError with every
        mistake.
        """
        text = self.to_yaml(self.room and self.room.absolute())
        with TemporaryDirectory(prefix="followspot-graph-") as folder:
            path = Path(folder) / "graph.yaml"
            path.write_text(text, encoding="utf-8")
            name = f"<Graph {self.name}>"
            try:
                found = compile_graph(path, **options)
            except InputError as error:
                raise InputError(_placed(error.mistakes, path, name, text)) from None
        return replace(found, source_files=None, warnings=_placed(found.warnings, path, name, text))

    def _repr_svg_(self) -> str | None:
        try:
            return svg(self.plan())
        except InputError:  # it is not complete yet
            return None

    def __repr__(self) -> str:
        return f"<Graph {self.name}: {', '.join(self.stages) or 'no stages'}>"


def _placed(mistakes: Sequence[Mistake], path: Path, name: str, text: str) -> tuple[Mistake, ...]:
    """Mistakes in a temporary file, with its text in place of its path, which is gone when they are read."""

    def found(place: Place | None) -> Place | None:
        if place is None:
            return None
        place = replace(place, outer=found(place.outer))
        return replace(place, file=name, written=text) if place.file == str(path) else place

    return tuple(replace(mistake, place=found(mistake.place)) for mistake in mistakes)


def _inputs(stage: type[Stage], names: Collection[str]) -> set[str]:
    """The names that mean inputs of the stage."""
    found, taken = ports(stage), stage.Params.model_fields
    return {name for name in names if name not in taken and found.input(name) is not None}

"""The plan: every stage instance in its worker, every edge with its kind. Pure data that can be shipped."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import Field

from followspot.errors import Mistake
from followspot.graph.budget import Budget
from followspot.graph.depths import LIVE_DEPTH, MAX_DEPTH, MAX_IN_TRANSIT
from followspot.graph.provenance import ParameterOrigin, SourceFiles
from followspot.graph.scheduling import Scheduling
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room import Member, Room
from followspot.valid_values.numbers import Wait
from followspot.yaml.node import Node

EdgeKind = Literal["reference", "ring", "zenoh"]
EdgeCodec = Literal["raw", "lossless", "jpeg"]
ErrorPolicy = Literal["fail", "skip", "restart"]
EdgePolicy = Literal["block", "drop_oldest", "latest"]
MAX_DELAY = 1000
"""Largest delay of feedback, firings."""
MAX_CONCURRENCY = 64
"""Most answers that one stage may compute at once."""
MAX_SEED = (1 << 63) - 1
"""Largest seed of the random numbers of a run."""
MAX_NEW_EDGES = 1024
"""Edges that a graph may get while it runs: the ledger has rows for them from the start."""


@dataclass(frozen=True)
class PlannedStage:
    """One stage instance and the worker that runs it."""

    name: str
    """Unique, for example ``color/cam0``; the group alone if the stage does not fan out."""
    group: str
    """Name of the stage in the graph file."""
    uses: str
    params: Mapping[str, Any]
    """Validated and made of JSON types."""
    member: Member | None
    """The camera, sensor, target or value of a tag that the instance serves, if the stage fans out."""
    worker: str
    live: bool
    on_error: ErrorPolicy = "fail"
    tolerance: Wait = 0.004
    """Largest difference in capture time within one join, s."""
    deadline: Wait = 0.1
    """Longest time, s, that a live join waits for missing messages, in addition to the waits of joins
    upstream.

    It counts from the time at which a message entered the graph.
    """
    depth: Annotated[int, Field(ge=1, le=MAX_DEPTH)] = LIVE_DEPTH
    """Messages of a live source that wait for the graph before the oldest is dropped."""
    concurrency: Annotated[int, Field(ge=1, le=MAX_CONCURRENCY)] = 1
    """Most answers of a stage with `Deferred` outputs that are under way at once."""
    kept: tuple[str, ...] = ()
    """The parameters that `--set` or a change gave, so that a tune or another graph file leaves them."""
    sees: tuple[str, ...] | None = None
    """The cameras that the stage knows, in a sub-graph that is given a part of the room; None for all."""

    @property
    def camera(self) -> str | None:
        """Name of the camera that the instance serves; None if it serves none."""
        return self.member.name if self.member is not None and self.member.set == "cameras" else None


@dataclass(frozen=True)
class PlannedEdge:
    """From one output port to one input port."""

    from_stage: str
    from_port: str
    to_stage: str
    to_port: str
    kind: EdgeKind
    delay: Annotated[int, Field(ge=0, le=MAX_DELAY)] = 0
    """Feedback: deliver the message of this many firings ago; 0 for a forward edge."""
    depth: Annotated[int, Field(ge=1, le=MAX_DEPTH)] = 8
    """Most messages in flight."""
    codec: EdgeCodec = "raw"
    """How arrays travel on an edge over Zenoh."""
    tolerance: Wait | None = None
    """Largest difference in capture time to its matches, s; None for the tolerance of the stage."""
    policy: EdgePolicy = "block"
    """Behaviour of a full edge in live runs: the sender waits, or the oldest message is dropped."""

    @property
    def name(self) -> str:
        """Shown to users: ``color/cam0.out -> verify.blobs``."""
        return f"{self.from_stage}.{self.from_port} -> {self.to_stage}.{self.to_port}"

    @property
    def shown_kind(self) -> str:
        """For display: the kind, the codec unless it is raw, and the policy if it drops."""
        carried = self.kind if self.codec == "raw" else f"{self.kind} {self.codec}"
        dropping = {"block": "", "latest": ", latest", "drop_oldest": f", drop_oldest {self.depth}"}
        return carried + dropping[self.policy]

    @property
    def drops(self) -> bool:
        """True if a slow reader loses messages in a live run instead of blocking the sender."""
        return self.policy != "block"

    @property
    def capacity(self) -> int:
        """Most messages in transit or waiting: feedback needs its delay and one more."""
        return self.depth + MAX_IN_TRANSIT if self.drops else max(self.depth, self.delay + 2)


@dataclass(frozen=True)
class PlannedWorker:
    """One operating-system process."""

    name: str
    host: str = ""
    scheduling: Scheduling = Scheduling()


def nearest_kind(start: PlannedWorker, end: PlannedWorker) -> EdgeKind:
    """The nearest kind of edge from one worker to another."""
    if start.host != end.host:
        return "zenoh"
    return "reference" if start.name == end.name else "ring"


@dataclass(frozen=True)
class Plan:
    """A run before it starts: stages in topological order (ignoring feedback edges), edges, workers."""

    graph: str
    room: Room
    stages: tuple[PlannedStage, ...]
    edges: tuple[PlannedEdge, ...]
    workers: tuple[PlannedWorker, ...]
    seed: int = 0
    plugin_files: tuple[str, ...] = ()
    """Absolute paths of one-file plugins."""
    notes: tuple[str, ...] = field(default=())
    """Differences from the request, for example an edge kind that was not possible."""
    offered: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, with the ports behind each."""
    warnings: tuple[Mistake, ...] = ()
    """Parts of the graph that can never give a result, with their places; only the operator has them."""
    subgraphs: tuple[SubgraphUse, ...] = ()
    """The graph files in the places of stages."""
    room_document: Node | None = field(default=None, repr=False, compare=False)
    """The document of the room file; only the operator has it."""
    origins: Mapping[str, Mapping[str, ParameterOrigin]] = field(default_factory=dict, compare=False)
    """The origin of each parameter that is not a default, by stage and parameter; for the operator."""
    source_files: SourceFiles | None = field(default=None, compare=False)
    """The files that the plan was made of; None without files, or if it was changed; for the operator."""
    numbers: tuple[int, ...] = ()
    """Number of each edge, which it keeps while the run goes on; empty as long as they are 0, 1, 2, ..."""
    former: tuple[tuple[int, PlannedEdge], ...] = ()
    """Edges that have left the graph while it ran, with their numbers."""
    budgets: tuple[Budget, ...] = ()
    """The longest times of paths."""
    additions: tuple[int, ...] = ()
    """For each change of the graph while it ran, the first number of the edges that came with it."""

    def numbered(self) -> Iterable[tuple[int, PlannedEdge]]:
        """Each edge with its number, which is its row in the ledger."""
        return zip(self.numbers or range(len(self.edges)), self.edges, strict=True)

    def edge(self, number: int) -> PlannedEdge:
        """The edge of this number. Raises KeyError."""
        return self._by_number[number]

    @property
    def rows(self) -> int:
        """Rows of the ledger: more than the largest number of an edge that is or was."""
        return 1 + max((number for number, _ in (*self.numbered(), *self.former)), default=-1)

    def addition(self, number: int) -> int:
        """Which change of the graph an edge came with, 0 if it was there from the start."""
        return bisect_right(self.additions, number)

    @property
    def live(self) -> bool:
        """True if any source delivers at its own pace; otherwise no message is dropped."""
        return any(stage.live for stage in self.stages)

    def room_of(self, stage: PlannedStage) -> Room:
        """The room as the stage knows it."""
        return self.room.with_cameras(stage.sees)

    def worker_of(self, stage: str) -> str:
        """Name of the worker that runs this stage. Raises KeyError."""
        return self._workers[stage]

    def scheduling_of(self, worker: str) -> Scheduling:
        """How this worker is scheduled. Raises KeyError."""
        return {found.name: found.scheduling for found in self.workers}[worker]

    def host_of(self, worker: str) -> str:
        """Host of this worker, "" for the operator's own. Raises KeyError."""
        return self._hosts[worker]

    def host_of_stage(self, stage: str) -> str:
        """Host of the worker that runs this stage. Raises KeyError."""
        return self.host_of(self.worker_of(stage))

    def stages_on(self, host: str) -> tuple[PlannedStage, ...]:
        """The stages of a host, "" for the operator's own."""
        return tuple(stage for stage in self.stages if self.host_of(stage.worker) == host)

    def ring_edges(self) -> list[int]:
        """Numbers of the edges between two workers of one host, which need a socket pair each."""
        return [number for number, edge in self.numbered() if edge.kind == "ring"]

    def uses_zenoh(self, worker: str | None = None) -> bool:
        """Whether any edge, or any edge of this worker, goes over Zenoh."""
        return any(
            edge.kind == "zenoh"
            and (worker is None or worker in map(self.worker_of, (edge.from_stage, edge.to_stage)))
            for edge in self.edges
        )

    def placed(self, stage: str) -> PlannedWorker:
        """The worker that runs this stage, with its host. Raises KeyError."""
        worker = self.worker_of(stage)
        return PlannedWorker(worker, self.host_of(worker))

    @cached_property
    def _by_number(self) -> Mapping[int, PlannedEdge]:
        return dict(self.numbered())

    @cached_property
    def _workers(self) -> Mapping[str, str]:
        return {stage.name: stage.worker for stage in self.stages}

    @cached_property
    def _hosts(self) -> Mapping[str, str]:
        return {worker.name: worker.host for worker in self.workers}

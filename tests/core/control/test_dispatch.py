"""Control messages: each names its roles, and round-trips exactly over every carrier."""

from __future__ import annotations

import importlib
import json
import math
import pkgutil
from collections.abc import Iterator
from typing import Any

import pytest

import followspot.control
import followspot.operator.run_requests  # defines the operator's requests
from followspot.control.dispatch import (
    Dispatcher,
    Request,
    RunRequest,
    UnknownRequest,
    answer_from_wire,
    answer_to_wire,
    to_wire,
    verb,
)
from followspot.control.host import RunOrder
from followspot.control.lifecycle import GetOrder, ListRuns, PrepareRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetStates, ReadClock
from followspot.control.process_identity import ProcessIdentity
from followspot.control.swap import ChangeOrder
from followspot.graph.plan import PlannedStage

STATES = {"a": {"big": 2**127 + 1, "nothing": math.nan, "end": -math.inf, "small": 5e-324, "no": -0.0}}
ORDER = RunOrder("feedc0de", {"x": [math.inf]}, 7, None, True, operator=ProcessIdentity("desk", pid=5))


def kinds(base: type[Request] = Request) -> Iterator[type[Request]]:
    """All requests of the project."""
    for module in pkgutil.iter_modules(followspot.control.__path__, "followspot.control."):
        importlib.import_module(module.name)
    for kind in base.__subclasses__():
        if kind.__module__.startswith("followspot.") and not kind.__name__.startswith("_"):
            yield kind
        yield from kinds(kind)


def test_every_request_has_roles_and_a_unique_verb() -> None:
    found = [kind for kind in kinds() if kind is not RunRequest]
    assert len(found) > 15
    assert len({verb(kind) for kind in found}) == len(found)
    for kind in found:
        assert kind.roles, kind
        assert set(kind.roles) <= {"operator", "host", "worker"}
        kind.model_rebuild()  # resolves its types


@pytest.mark.parametrize(
    "request_",
    [
        PrepareRun(order=ORDER),
        MoveOrder(run="a", leaving=("b",), plan={"stages": []}, states=STATES, trial=True),
        ChangeOrder(
            run="a",
            id="1",
            step="build",
            stages=(PlannedStage("fuse", "fuse", "balls.mean", {"gate": 0.1}, None, "main", live=False),),
        ),
        StopRun(run="a"),
    ],
    ids=lambda request: type(request).__name__,
)
def test_a_request_round_trips_exactly(request_: Request) -> None:
    arrived: list[Request] = []
    dispatcher = Dispatcher("host", {type(request_): arrived.append})
    dispatcher.dispatch_wire(json.loads(json.dumps(to_wire(request_))))
    assert repr(arrived) == repr([request_])  # not ==, for NaN


def test_answers_round_trip_exactly() -> None:
    def told(kind: type[Request], answer: Any) -> Any:
        return answer_from_wire(kind, json.loads(json.dumps(answer_to_wire(kind, answer))))

    assert repr(told(GetStates, STATES)) == repr(STATES)
    assert told(GetOrder, ORDER) == ORDER
    assert told(StopRun, None) is None


@pytest.mark.parametrize(
    "data",
    [
        5,
        None,
        {},
        {"verb": "nobody_knows"},
        {"verb": []},
        {"verb": "stop_run", "run": 5},
        {"verb": "stop_run", "x": 1},
    ],
)
def test_an_invalid_request_is_refused_before_any_handler(data: Any) -> None:
    heard: list[Request] = []
    with pytest.raises((ValueError, UnknownRequest)):
        Dispatcher("host", {StopRun: heard.append}).dispatch_wire(data)
    assert heard == []


def test_a_role_handles_only_its_own_requests() -> None:
    with pytest.raises(TypeError, match="no worker handles: ListRuns"):
        Dispatcher("worker", {ListRuns: lambda _: []})


def test_a_request_is_immutable() -> None:
    request = StopRun(run="a")
    with pytest.raises(ValueError, match="frozen"):
        request.run = "b"  # type: ignore[misc]


def test_hosts_may_only_read_clocks() -> None:
    assert [kind for kind in kinds() if kind.open_to_hosts] == [ReadClock]

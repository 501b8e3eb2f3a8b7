"""Targets: what comes to an agent and to a coordinator over the network."""

from __future__ import annotations

import json
import random
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from uuid import UUID

from followspot.control.dispatch import answer_from_wire, answer_to_wire, fields
from followspot.control.host import HostStatus, RunOrder, WorkerStatus
from followspot.control.lifecycle import PrepareRun
from followspot.control.observation import GetHostStatus
from followspot.control.plan_transfer import packed, unpacked
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.security.grants import Grants
from followspot.security.request_guard import FORMAT, Asked, RequestGuard
from followspot.transport.host_registry import read_host_registry
from fuzzing.mutation import broken_bytes, broken_text
from fuzzing.target import Target
from fuzzing.trees import broken_tree

ROOT = Path(__file__).parents[2]
HOST = "pc-left"


def _plan() -> Plan:
    plan = compile_graph(ROOT / "graphs/glowballs.yaml", placement="camera")
    return replace(plan, workers=tuple(replace(worker, host=HOST) for worker in plan.workers))


def request_target() -> Target:
    """Requests as bytes, from the key to the plan that is unpacked; nothing is started."""
    gate = RequestGuard(HOST, {"prepare_run", "stop_run"}, clock=lambda: 1000.0)
    prepare = fields(PrepareRun(order=RunOrder("run", packed(_plan(), HOST, Path()), 10)))
    keys = [f"followspot/agent/{HOST}/{verb}/operator/desk" for verb in ("prepare_run", "stop_run")]

    def make(rng: random.Random) -> tuple[str, bytes]:
        name = UUID(int=rng.getrandbits(128)).hex
        verb = rng.choice(("prepare_run", "prepare_run", "stop_run"))
        data: Any = prepare if verb == "prepare_run" else {"run": "run"}
        tree: Any = {"format": FORMAT, "id": name, "time": 1000.0, "data": data}
        tree["asked"] = [HOST, verb, "operator", "desk"]
        way = rng.random()
        if way < 0.4:
            tree["data"] = broken_tree(data, rng)
        elif way < 0.6:
            tree = broken_tree(tree, rng)
        key = next(key for key in keys if f"/{verb}/" in key)
        if way > 0.95:
            key = broken_text(key.encode(), rng, [k.encode() for k in keys]).decode("utf-8", "replace")
        text = json.dumps(tree).encode("utf-8", "surrogatepass")
        return key, broken_bytes(text, rng) if way > 0.7 else text

    def take(made: tuple[str, bytes]) -> object:
        asked = Asked.of(made[0])
        data = gate.admit(asked, made[1])
        return _unpacked(data) if asked.verb == "prepare_run" else data

    return Target(make, take, (FollowspotError, ValueError, TypeError, KeyError))


def _unpacked(data: Any) -> object:
    """The agent's handling of an order before it starts a worker."""
    order = PrepareRun.model_validate(data).order
    plan = unpacked(order.plan, HOST, Grants(), ())
    return order.here(plan, "out"), plan_from_data(plan).graph


def status_target() -> Target:
    """Statuses of hosts, as a coordinator gets them."""
    workers = WorkerStatus("a", "running", 3, 5), WorkerStatus("b", "over")
    valid = answer_to_wire(GetHostStatus, HostStatus(workers, (1, 2, 3), ("x",)))
    return Target(
        lambda rng: broken_tree(valid, rng), partial(answer_from_wire, GetHostStatus), (ValueError,)
    )


def registry_target() -> Target:
    """Lists of hosts."""
    folder = TemporaryFolder("fuzz")
    expires = time.strftime("2036-%m-%dT00:00:00+00:00", time.gmtime(0))
    entry = {"role": "camera", "expires": expires}
    text = json.dumps({"format": FORMAT, "own": "a", "hosts": {"a": entry, "b": entry}}).encode()

    def take(data: bytes) -> object:
        path = folder.path / "hosts.json"
        path.write_bytes(data)
        return read_host_registry(path)

    return Target(lambda rng: broken_text(text, rng, [text]), take, (FollowspotError,))

"""A listener of ports without Zenoh edges: Zenoh, msgpack and numpy alone."""

from __future__ import annotations

import json
import math

import msgpack
import numpy as np
import zenoh
from tests.integration.going import wait_until


def heard_by_a_stranger(endpoint: str, keys: list[str], more: int) -> list[list[int]]:
    """Values of ports without Zenoh edges, read by Zenoh, msgpack and numpy alone (docs/wire.md)."""
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    values: list[list[int]] = [[] for _ in keys]

    def take(sample: zenoh.Sample, into: list[int]) -> None:
        data = sample.payload.to_bytes()
        size = int.from_bytes(data[2:4], "little")
        kind, _, _, _, _, scalars, ((name, dtype, shape),) = msgpack.unpackb(data[4 : 4 + size])
        start = -(-(4 + size) // 64) * 64
        load = np.frombuffer(data, dtype, math.prod(shape), start)
        assert (kind, name, load.size) == ("Tick", "load", 0)
        into.append(scalars["value"])

    with zenoh.open(config) as session:
        for key, into in zip(keys, values, strict=True):
            session.declare_subscriber(key, lambda sample, into=into: take(sample, into))
        assert wait_until(lambda: all(len(into) > more for into in values))
    return values

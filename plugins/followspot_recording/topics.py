"""How ports are named in a recording."""

from __future__ import annotations

ENCODING = "followspot"
"""Of exact messages, docs/wire.md; also of their schemas, docs/recordings.md."""
_PREFIX = "/followspot/"


def exact_topic(port: str) -> str:
    """Topic of the exact messages of STAGE.PORT: /followspot/STAGE/PORT."""
    stage, _, name = port.rpartition(".")
    return f"{_PREFIX}{stage}/{name}" if stage else f"{_PREFIX}{name}"


def view_topic(port: str) -> str:
    """Topic of the copies for viewers: /STAGE, or /STAGE/PORT if the port has a name of its own."""
    stage, _, name = port.rpartition(".")
    return f"/{stage}" if name == "out" else f"/{stage}/{name}" if stage else f"/{name}"


def port_of(topic: str) -> str | None:
    """STAGE.PORT behind the topic of exact messages; None for other topics."""
    stage, _, name = topic.removeprefix(_PREFIX).rpartition("/")
    return f"{stage}.{name}" if topic.startswith(_PREFIX) and stage else None

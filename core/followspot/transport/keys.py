"""The key space: who may put, answer or ask what can be told from a key alone, so that Zenoh can enforce it.

``followspot/RUN/HOST/STAGE/PORT``             what a port sends, put by the stage's host
``followspot/RUN/HOST/STAGE/PORT/alive/...``   presence of the writer, by the stage's host
``followspot/RUN/HOST/STAGE/PORT/.reader/READER/...``   what readers of the port on the host READER say
``followspot/RUN/HOST/STAGE/PORT/look/TAP``    what a tap tells those who look on from other hosts
``followspot/agent/HOST``                      presence of an agent
``followspot/agent/HOST/VERB/ROLE/NAME``       what an agent answers, to whom: role and name as certified
"""

from __future__ import annotations

ROOT = "followspot"
AGENTS = f"{ROOT}/agent"
OPERATOR = "operator"
"""Stands for the operator's own host, which has no name in rooms and placements."""


def port_key(run: str, host: str, stage: str, port: str) -> str:
    """What one output port of a run sends; host: "" for the operator's own."""
    return f"{ROOT}/{run}/{host or OPERATOR}/{stage}/{port}"


def reader_key(port: str, host: str) -> str:
    """Below the key of a port, what its readers on one host say; ``*`` stands for any host.

    No stage has a dot in its name, so the key of no port has this chunk.
    """
    return f"{port}/.reader/{host or OPERATOR}"


def look_key(run: str, host: str, name: str, tap: str) -> str:
    """What a tap tells of a port; name: STAGE.PORT, tap: the stage that looks at it."""
    stage, _, port = name.rpartition(".")
    return f"{port_key(run, host, stage, port)}/look/{tap}"


def agent_key(host: str) -> str:
    """Presence of an agent."""
    return f"{AGENTS}/{host}"


def request_key(host: str, verb: str, role: str, name: str) -> str:
    """A request to an agent by somebody of this role and name; ``*`` where it does not matter."""
    return f"{AGENTS}/{host}/{verb}/{role}/{name}"

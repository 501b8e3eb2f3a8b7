"""The Zenoh keys: a key alone tells which host may put, answer or ask on it, so that Zenoh can enforce it.

``followspot/RUN/HOST/STAGE/PORT``             what a port sends, put by the stage's host
``followspot/RUN/HOST/STAGE/PORT/alive/...``   presence of the writer, by the stage's host
``followspot/RUN/HOST/STAGE/PORT/.reader/READER/...``   reports of the port's readers on the host READER
``followspot/RUN/HOST/STAGE/PORT/look/TAP``    what a tap sends to observers on other hosts
``followspot/agent/HOST``                      presence of an agent
``followspot/agent/HOST/VERB/ROLE/NAME``       requests to an agent: role and name of the client, as certified
"""

from __future__ import annotations

ROOT = "followspot"
AGENTS = f"{ROOT}/agent"
OPERATOR = "operator"
"""Stands for the operator's own host, which has no name in rooms and placements."""


def port_key(run: str, host: str, stage: str, port: str) -> str:
    """Key of one output port of a run; host: "" for the operator's own."""
    return f"{ROOT}/{run}/{host or OPERATOR}/{stage}/{port}"


def reader_key(port: str, host: str) -> str:
    """Key, below that of a port, for reports of its readers on one host; ``*`` stands for any host.

    No stage has a dot in its name, so the key of no port has this chunk.
    """
    return f"{port}/.reader/{host or OPERATOR}"


def tap_key(run: str, host: str, name: str, tap: str) -> str:
    """Key of a tap; name: the STAGE.PORT that it is at, tap: the plugin of its sink."""
    stage, _, port = name.rpartition(".")
    return f"{port_key(run, host, stage, port)}/look/{tap}"


def agent_key(host: str) -> str:
    """Presence of an agent."""
    return f"{AGENTS}/{host}"


def request_key(host: str, verb: str, role: str, name: str) -> str:
    """Key of requests to an agent from a client of this role and name; ``*`` stands for any."""
    return f"{AGENTS}/{host}/{verb}/{role}/{name}"

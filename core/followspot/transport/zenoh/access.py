"""Zenoh's access control from the registry of hosts: what each certified host may put, answer, ask and see.

Every session and router checks what comes in, so a host gains nothing if it breaks its own rules. A host may
put under its own name only, report for its own readers only, and ask agents under its own role and name only.
So an agent can believe the key of a request, and a writer the key of a report.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from followspot.transport.host_registry import RegisteredHost
from followspot.transport.keys import AGENTS, OPERATOR, ROOT, agent_key, reader_key, request_key

_ALL = (
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "declare_queryable",
    "reply",
    "liveliness_token",
    "declare_liveliness_subscriber",
    "liveliness_query",
)
_SEE = ("declare_subscriber", "declare_liveliness_subscriber", "liveliness_query")
_PORT = f"{ROOT}/*/*/*/*/**"
"""All keys below a port: RUN, HOST, STAGE and PORT are at least four chunks."""


def access_control(members: Sequence[RegisteredHost]) -> dict[str, Any]:
    """Zenoh's setting ``access_control``, which denies all that it does not allow."""
    rules = [_rule("out", "egress", _ALL, [f"{ROOT}/**"]), _rule("see", "ingress", _SEE, [f"{ROOT}/**"])]
    policies = [{"rules": ["out", "see"], "subjects": [member.name for member in members]}]
    for member in members:
        own = [
            _rule(f"{member.name} {number}", "ingress", *grant)
            for number, grant in enumerate(_grants(member))
        ]
        rules += own
        policies.append({"rules": [rule["id"] for rule in own], "subjects": [member.name]})
    subjects = [{"id": member.name, "cert_common_names": [member.name]} for member in members]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _grants(member: RegisteredHost) -> list[tuple[Sequence[str], list[str]]]:
    """Kinds of Zenoh messages, and the keys on which sessions accept them from this host."""
    name, role = member.name, member.role
    if role == "router":
        return [(_ALL, [f"{ROOT}/**"])]
    hosts = [name, OPERATOR] if role == OPERATOR else [name]
    ports = [f"{ROOT}/*/{host}/**" for host in hosts]
    reports = [f"{reader_key(_PORT, host)}/**" for host in hosts]
    return [
        (["put"], [*ports, *reports]),
        (["liveliness_token"], [*ports, *reports, agent_key(name)]),
        (["declare_queryable", "reply"], [f"{AGENTS}/{name}/**"]),
        (["query"], [request_key("*", "*", role, name)]),
    ]


def _rule(name: str, flow: str, messages: Sequence[str], keys: Sequence[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(keys),
    }

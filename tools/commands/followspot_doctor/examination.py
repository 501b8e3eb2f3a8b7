"""All checks, one after the other; one that fails itself is a finding, too."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from followspot import Network
from followspot_doctor.checks import cameras, hosts, libraries, machine, network, plugins, sensors, timing
from followspot_doctor.finding import Finding, doubtful

Check = tuple[str, Callable[[], Iterator[Finding]]]
"""The subject of a check, and its findings."""


@dataclass(frozen=True)
class Subject:
    """Subjects beside this host."""

    room: Path | None = None
    graph: str | None = None
    timing: bool = False
    """Whether the live cameras of the room are watched together."""
    out: Path = Path("runs")
    network: Network = Network()
    """The checks, with those of certificates and agents if the subject names them."""


def examine(subject: Subject) -> list[Finding]:
    """Everything that was found, in the order of the checks."""
    room = str(subject.room) if subject.room is not None else None
    checks: list[Check] = [
        ("computer", machine.computer),
        ("open files", machine.open_files),
        ("shared memory", machine.shared_memory),
        ("output folder", lambda: machine.output_folder(subject.out)),
        ("clock", machine.clock),
        ("loopback", network.loopback),
        ("multicast", network.multicast),
        ("ports", network.ports),
        ("zenoh", network.zenoh_session),
        ("opencv", libraries.opencv),
        ("extras", libraries.extras),
        ("plugins", plugins.stages),
        ("hooks", plugins.hooks),
    ]
    checks += _of_hosts(subject.network)
    if room is not None:
        checks.append(("cameras", lambda: cameras.cameras(room)))
        checks.append(("sensors", lambda: sensors.sensors(room)))
        if subject.timing:
            checks.append((timing.SUBJECT, lambda: timing.timing(room)))
    if subject.graph is not None:
        graph = subject.graph
        checks.append(("graph", lambda: plugins.graph(graph, room)))
    return [finding for name, check in checks for finding in _checked(name, check)]


def _of_hosts(found: Network) -> list[Check]:
    checks: list[Check] = []
    if found.certificates:
        checks.append(("certificates", lambda: hosts.certificates(Path(found.certificates))))
    if found.leads_somewhere:
        checks.append(("agents", lambda: hosts.agents(found)))
    return checks


def _checked(name: str, check: Callable[[], Iterator[Finding]]) -> list[Finding]:
    try:
        return list(check())
    except Exception as error:
        return [doubtful(name, f"could not be looked at: {type(error).__name__}: {error}", "")]

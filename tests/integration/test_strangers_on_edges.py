"""A program without a certificate sends on an edge: the run says what it refuses, and which edge stalls."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

from tests.integration.hosts import free_port
from tests.integration.running import start, wait_until, write_graph

from followspot.operator.connect import run_here
from followspot.operator.discovery import operator_session
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.terms import NUMBER

GRAPH = """
a:    {uses: ticks.count, with: {count: 1000000}}
b:    {uses: ticks.add, in: {number: a}, with: {sleep: 0.001}}
save: {uses: ticks.write, in: {number: b}}
"""
REFUSES = (
    "warning: a.out -> b.number: refuses what was malformed or not from its sender; any program that reaches "
    "this run can send that, unless hosts have certificates"
)


def test_what_a_stranger_puts_on_an_edge_is_told_while_it_stalls_the_edge(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = ("--placement", "stage", "--edges", "zenoh", "--listen", endpoint)
    process = start(write_graph(tmp_path, GRAPH), tmp_path / "out", *options)
    written = tmp_path / "out" / "ticks.csv"
    assert wait_until(lambda: written.exists() and written.stat().st_size > 0)
    run = run_here(str(process.pid))

    def forge(sample: Any) -> None:
        """Send what nobody can read as the message after this one."""
        if sample.attachment is not None and sample.payload.to_bytes() != b"junk":
            writer, number, messages = NUMBER.unpack_from(sample.attachment.to_bytes())
            numbers = NUMBER.pack(writer, number + 1, messages + 1)
            session.put(sample.key_expr, b"junk", attachment=numbers)

    with operator_session(Network(connect=(endpoint,))) as session:
        subscriber = session.declare_subscriber(f"followspot/{run.run}/*/a/out", forge)
        stalls = "a.out -> b.number stalls: a has had no room to send for "
        assert wait_until(lambda: any(line.startswith(stalls) for line in run.status().faults()))
        subscriber.undeclare()
    process.send_signal(signal.SIGKILL)
    _, errors = process.communicate(timeout=60)
    assert REFUSES in errors

"""`followspot verify` of marked moments from the middle of a live run, byte for byte."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.tools.flight.bars import PORTS, differing, verified, wait_until

import followspot as fs
from followspot import Message
from followspot.graph.output_ports import output_ports
from followspot.messages import stamped
from followspot.ports.firing import Firing, firings_of
from followspot.wire import pack
from followspot_record.embedded import recorded_plan
from followspot_record.firings import firing_types
from followspot_record.flight.moment_file import MomentFile
from followspot_record.flight.recorder import FlightRecorder
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording


def moment(folder: Path, graph: str, placement: Path | None = None) -> Path:
    """A moment that begins in the middle of a run in which a parameter changed."""
    plugins, out = [folder / "bars.py"], folder / ("out" if placement is None else "apart")
    with fs.run(folder / graph, plugin_files=plugins, out=out, keep="2s", placement=placement) as run:
        wait_until(lambda: (kept := run.kept()) is not None and kept.held > 1.5)
        wait_until(lambda: (kept := run.kept()) is not None and kept.messages > 2400)  # at most 800 a second
        fired = run.status().fired
        run.set("sum.factor", 3)
        wait_until(lambda: run.status().fired > fired + 20)
        marked = run.mark(after=0.2, wait=True)
        assert marked.lost == 0
        run.stop()
    return Path(marked.file)


@pytest.fixture(scope="module")
def marked(folder: Path) -> Path:
    return moment(folder, "secret.yaml")


def again(path: Path, to: Path, folder: Path, change: Callable[[str, Message], Message | None]) -> Path:
    """A copy of a moment with other messages."""
    with Recording(path) as recording:
        plan = recorded_plan(recording, [str(folder / "bars.py")])
        ports = output_ports(plan)
        types = {**ports, **firing_types(plan, ports)}
        recorder = FlightRecorder(60.0, 1 << 28, lambda: MomentFile(to, plan, types, {}, 1 << 28))
        for port, kind in types.items():
            for message in decoded(recording, port, kind):
                changed = change(port, message)
                if changed is not None:
                    recorder.put(port, message.header.time, 0, pack(stamped(changed, message.header)))
        recorder.mark(0.0, "")
        recorder.close()
    return to


def test_a_live_moment_from_the_middle_is_the_same_byte_for_byte(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of two workers; with a join's deadline, an edge that drops, an input that goes by arrival, a `set`."""
    path = moment(folder, "bars.yaml", folder / "apart.yaml")
    found = verified(path, folder, capsys)
    assert found["same"], found
    assert {port["port"] for port in found["ports"]} == PORTS
    assert all(port["messages"] > 20 for port in found["ports"]), found
    with Recording(path) as recording:
        assert set(recording.ports) == {"left.out", "right.out", *PORTS}
        numbers = [message.header.seq for message in decoded(recording, firings_of("sum"), Firing)]
        assert numbers[0] > 0
        assert numbers == list(range(numbers[0], numbers[-1] + 1))


def test_a_stage_that_remembers_without_a_state_is_named(
    marked: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = verified(marked, folder, capsys)
    assert differing(found) == ["secret.out"]
    assert "secret has no `state`: a memory from before the recording is not in it" in found["notes"]
    with Recording(marked) as recording:
        assert recording.metadata["without_state"] == "meet, slow, secret"


def middle(path: Path, port: str) -> int:
    """Capture time, ns, of the message in the middle of a port."""
    with Recording(path) as recording:
        times = [message.time for message in recording.messages(port)]
    return times[len(times) // 2 + 1]


def test_a_message_that_is_missing_or_another_is_found(
    marked: Path, tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gone, other = middle(marked, "meet.out"), middle(marked, "sum.out")

    def change(port: str, message: Message) -> Message | None:
        if port == "meet.out" and message.header.time == gone:
            return None
        if port == "sum.out" and message.header.time == other:
            return replace(message, bar=7)  # type: ignore[type-var]
        return message

    found = verified(again(marked, tmp_path / "a.mcap", folder, change), folder, capsys)
    assert differing(found) == ["meet.out", "sum.out", "secret.out"]
    said = {port["port"]: port["difference"] for port in found["ports"]}
    assert "bar 7 is now " in said["sum.out"]


def test_what_took_a_message_that_is_missing_is_not_repeated_and_named(
    marked: Path, tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Recording(marked) as recording:
        firings = list(decoded(recording, firings_of("sum"), Firing))
    plain = [firing for firing in firings[len(firings) // 2 :] if not len(firing.checkpoint)]
    gone = plain[0].header.time  # no checkpoint contains that message
    path = again(
        marked,
        tmp_path / "a.mcap",
        folder,
        lambda port, message: None if (port, message.header.time) == ("left.out", gone) else message,
    )
    found = verified(path, folder, capsys)
    assert differing(found) in ([], ["secret.out"])
    assert any("sum" in note and "left.out lacks messages" in note for note in found["notes"]), found


def test_what_reads_a_port_that_was_not_kept_is_named(
    marked: Path, tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = again(
        marked,
        tmp_path / "a.mcap",
        folder,
        lambda port, message: None if port in ("left.out", "right.out") else message,
    )
    found = verified(path, folder, capsys)
    said = [note for note in found["notes"] if "slow" in note.partition(":")[0]]
    assert any("right.out is not recorded" in note for note in said), found
    messages = {port["port"]: port["messages"] for port in found["ports"]}
    assert messages["slow.out"] <= 3, "what a checkpoint contains"

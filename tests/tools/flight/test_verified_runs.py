"""`followspot verify` of recordings of whole live runs, byte for byte."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.tools.flight.bars import PORTS, differing, fire, running, verified

from followspot.ports.firing import Firing, firings_of
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording


@pytest.fixture(scope="module")
def show(folder: Path) -> Path:
    """A recording of a live run of two workers, in the middle of which a parameter changed."""
    path = folder / "show.mcap"
    plugin, apart = ("--plugin", folder / "bars.py"), ("--placement", folder / "apart.yaml")
    words = (folder / "secret.yaml", *plugin, *apart, "--out", folder / "out", "--record", path)
    with running(*words) as run:
        fire(run, 200)
        run.set("sum.factor", 3)
        fire(run, 100)
    return path


def test_a_live_run_is_the_same_byte_for_byte_from_its_first_message(
    show: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a join's deadline, an edge that drops, an input that goes by arrival, and a `set`."""
    found = verified(show, folder, capsys)
    assert found["same"], found
    assert not found["notes"]
    assert {port["port"] for port in found["ports"]} == {*PORTS, "secret.out"}
    with Recording(show) as recording:
        for port in found["ports"]:
            recorded = list(recording.messages(port["port"]))
            assert port["messages"] == len(recorded) > 20, port
            stage = port["port"].partition(".")[0]
            numbers = [firing.header.seq for firing in decoded(recording, firings_of(stage), Firing)]
            assert numbers == list(range(len(numbers))), "every firing from the first one on"


def test_the_recording_of_a_live_run_says_which_stages_have_no_state(show: Path) -> None:
    with Recording(show) as recording:
        assert recording.metadata["without_state"] == "meet, slow, secret"
        assert recording.metadata["live"] == "true"


def test_what_is_read_is_not_recorded_and_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Firings of a stage without what it read cannot be repeated; what reads recorded ports alone can."""
    path = folder / "part.mcap"
    plugin = ("--plugin", folder / "bars.py")
    words = (folder / "bars.yaml", *plugin, "--out", folder / "part", "--record", path)
    with running(*words, "--record-ports", "left,slow,sum") as run:
        fire(run, 100)
    found = verified(path, folder, capsys)
    assert not differing(found)
    rows = {port["port"]: port for port in found["ports"]}
    assert rows.keys() == {"slow.out", "sum.out"}
    assert rows["sum.out"]["messages"] > 10
    assert any(
        "right.out is not recorded" in note for note in [*found["notes"], rows["slow.out"]["unrepeated"]]
    )

"""`check`: mistakes in a graph and its options are data, before anything starts."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest
from tests.core.library.scripts import GRAPH, ROOM, composed

import followspot as fs
from followspot import room_file
from followspot.tracking import Candidates, Forecast, Positions, Tracks


def test_mistakes_are_data_with_their_places() -> None:
    (mistake,) = fs.check(GRAPH, set={"fuse.steps": 3})
    assert 'no parameter "steps"' in mistake.text
    assert 'did you mean "maximum_iterations"' in mistake.remedy


class Quiet(fs.Stage):
    """Find nothing."""

    def process(self, candidates: Candidates, forecast: fs.Latest[Forecast] = None) -> Positions:
        return Positions.empty()


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"edges": "rings"}, 'edges is .rings.\\n    did you mean "ring"'),
        ({"seed": -3}, r"seed is -3\n    give a whole number from 0 to 9223372036854775807"),
        ({"seed": 1 << 63}, "seed is 9223372036854775808"),
        ({"seed": "7"}, "seed is '7'"),
        ({"room": room_file.load(ROOM)}, r"room is of type Room\n +give the path of a room file; .*save"),
        ({"placement": 2}, 'placement is of type int\n +give "camera", "stage", or the path'),
        ({"cameras": ["cam0", 3]}, r"cameras is \['cam0', 3\]\n +give a text, or a list of texts"),
        ({"plugin_files": 3}, "plugin_files is 3"),
        ({"set": {3: "balls.mean"}}, "set is {3: 'balls.mean'}\n +give a mapping"),
        ({"ports": 3}, "ports is 3"),
        ({"ports": ["track.trcks"]}, 'ports: there is no port "track.trcks"\n +did you mean "track.tracks"'),
        ({"set": {"fuse.uses": Quiet}, "placement": "camera"}, "fuse: a class .* beside several workers"),
    ],
)
def test_an_option_that_cannot_be_is_refused_with_what_can(option: dict[str, Any], said: str) -> None:
    (mistake,) = fs.check(GRAPH, **option)
    assert re.match(said, str(mistake))


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"out": ""}, "out is empty\n +give the path of a folder"),
        ({"out": 3}, "out is of type int\n +give the path of a folder"),
        ({"media": None}, "media is of type NoneType"),
        ({"media": ""}, "media is empty\n +give the path of a folder"),
        ({"network": "tls/pc-left:7450"}, "network is of type str\n +give followspot.Network"),
    ],
)
def test_an_option_of_a_run_that_cannot_be_is_refused(option: dict[str, Any], said: str) -> None:
    with pytest.raises(fs.InputError, match=said):
        fs.run(GRAPH, **option)


def test_a_run_is_named_by_a_text() -> None:
    pid: Any = 4711
    with pytest.raises(fs.InputError, match=r"run is of type int\n +give its name"):
        fs.connect(pid)


class Collecting(fs.Stage):
    """Collects in its class, where all instances and runs of a notebook share what they find."""

    seen: list[int] = []  # noqa: RUF012
    names: Mapping[str, int] = {"red": 1}

    def process(self, tracks: Tracks) -> None:
        self.seen.append(tracks.header.seq)


def test_a_container_in_the_class_of_a_stage_is_warned_of() -> None:
    graph = composed()
    graph.add("collect", Collecting, tracks=graph.port("low"))
    (mistake,) = fs.check(graph)
    assert mistake.warning
    assert mistake.text == "here.collecting keeps the list seen in its class, for all its instances and runs"
    assert mistake.remedy == "make it in setup(self): self.seen = list()"

"""A target is learnt on the page: from a still picture, by a click or a rectangle, into the room file."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from tests.tools.own_ball import GRAPH, RADIUS, SIZE, room_for

import followspot as fs
from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.room_file import load
from followspot_dashboard.gate import make_gate
from followspot_page.allowed_requests import request_of
from followspot_page.page import Page
from followspot_page.requests.handler import Requests
from followspot_page.requests.reply import Reply


class Operator:
    """One browser of a page of a run."""

    def __init__(self, page: Page) -> None:
        self.requests = Requests(page)

    def ask(self, **asked: Any) -> Reply:
        return asyncio.run(self.requests.do(json.dumps(asked)))

    def refused(self, **asked: Any) -> str:
        with pytest.raises(FollowspotError) as error:
            self.ask(**asked)
        return str(error.value)


@pytest.fixture
def room(tmp_path: Path) -> str:
    return room_for(tmp_path)


@pytest.fixture
def operator(tmp_path: Path, room: str) -> Iterator[Operator]:
    """Of a run that plays the video again and again."""
    assert main(["calibrate", "targets", "--room", room, "--pick", "blue=30,30"]) == 0
    file = Path(room)
    file.write_text(file.read_text().replace("cameras.video", "cameras.playback"))
    with fs.run(GRAPH, room=room, out=tmp_path / "out", set={"camera.loop": True}) as run:
        page = Page(run.plan(), make_gate(tmp_path), tmp_path)
        page.ask = run
        yield Operator(page)
        run.stop()


def red_at(picture: bytes) -> tuple[int, int]:
    """The middle of the red ball in a JPEG."""
    pixels = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR).astype(int)
    rows, columns = np.nonzero(pixels[..., 2] - pixels[..., 0] > 100)
    return round(columns.mean()), round(rows.mean())


def test_a_target_is_learnt_by_a_click_on_a_still_picture_and_written_when_told(
    operator: Operator, room: str
) -> None:
    before = Path(room).read_text()
    still = operator.ask(still="cam0")
    assert still.about == {"camera": "cam0", "size": [*SIZE], "targets": {"blue": 0.0762}, "file": room}
    x, y = red_at(still.picture)
    learnt = operator.ask(learn="red", box=[x, y], radius=0.04).about
    assert learnt is not None
    assert (learnt["new"], learnt["radius_m"]) == (True, 0.04)
    assert learnt["pixels"] == pytest.approx(np.pi * (RADIUS + 0.5) ** 2, rel=0.1)
    assert learnt["center"] == [pytest.approx(x, abs=1), pytest.approx(y, abs=1)]
    (beside,) = learnt["alike"]
    assert (beside["name"], beside["confused"]) == ("blue", False)
    assert Path(room).read_text() == before  # until it is told
    assert f"red is in {room}" in operator.ask(write=True).text
    targets = load(room).targets
    assert set(targets) == {"blue", "red"}
    assert targets["red"].radius == 0.04
    assert targets["red"].area["cam0"] == tuple(learnt["area"])
    assert "nothing was learnt" in operator.refused(write=True)


def test_a_known_target_is_learnt_anew_by_a_rectangle_and_its_radius_stays(
    operator: Operator, room: str
) -> None:
    x, y = red_at(operator.ask(still="cam0").picture)
    box = [x - RADIUS, y - RADIUS, 2 * RADIUS + 1, 2 * RADIUS + 1]
    learnt = operator.ask(learn="blue", box=box, radius=None).about
    assert learnt is not None
    assert (learnt["new"], learnt["radius_m"], learnt["alike"]) == (False, 0.0762, [])
    twin = operator.ask(learn="red", box=box, radius=0.04).about  # as if it had another name
    operator.ask(write=True)
    again = operator.ask(learn="blue", box=box, radius=None).about
    assert twin is not None
    assert again is not None
    assert [one["confused"] for one in again["alike"]] == [True]  # red, from the same pixels


def test_the_page_and_the_command_learn_the_same(operator: Operator, room: str, tmp_path: Path) -> None:
    operator.ask(still="cam0")
    operator.ask(learn="other", box=[30, 30], radius=0.0762)
    operator.ask(write=True)
    targets = load(room).targets
    assert np.allclose(
        targets["other"].hue_histogram["cam0"], targets["blue"].hue_histogram["cam0"], atol=0.05
    )
    assert targets["other"].area["cam0"] == pytest.approx(targets["blue"].area["cam0"], rel=0.1)


def test_what_cannot_be_learnt_says_why_and_writes_nothing(operator: Operator, room: str) -> None:
    before = Path(room).read_text()
    assert operator.refused(learn="red", box=[30, 30], radius=0.04) == "take a picture first"
    assert operator.refused(still="cam9") == "there is no camera cam9"
    operator.ask(still="cam0")
    assert "red is a new target: give its radius" in operator.refused(learn="red", box=[30, 30], radius=None)
    assert "is not in the picture of 200 x 150 px" in operator.refused(learn="a", box=[200, 1], radius=1)
    assert "is not in the picture" in operator.refused(learn="a", box=[190, 1, 11, 1], radius=1)
    assert "is not in the picture" in operator.refused(learn="a", box=[1, 1, 0, 5], radius=1)
    assert "runs over" in operator.refused(learn="a", box=[100, 5], radius=1)
    assert Path(room).read_text() == before


def test_a_room_file_that_is_broken_meanwhile_is_left_as_it_is(operator: Operator, room: str) -> None:
    operator.ask(still="cam0")
    operator.ask(learn="red", box=[30, 30], radius=0.04)
    Path(room).write_text("cameras: [")
    assert Path(room).name in operator.refused(write=True)
    assert Path(room).read_text() == "cameras: ["


@pytest.mark.parametrize(
    "asked",
    [
        {"still": 1},
        {"still": "a" * 201},
        {"learn": "../room", "box": [1, 2], "radius": 1},
        {"learn": "", "box": [1, 2], "radius": 1},
        {"learn": "a" * 65, "box": [1, 2], "radius": 1},
        {"learn": "red\n", "box": [1, 2], "radius": 1},
        {"learn": "red", "box": [1], "radius": 1},
        {"learn": "red", "box": [1, 2, 3], "radius": 1},
        {"learn": "red", "box": [-1, 2], "radius": 1},
        {"learn": "red", "box": [1.5, 2], "radius": 1},
        {"learn": "red", "box": [1, 1 << 40], "radius": 1},
        {"learn": "red", "box": "12", "radius": 1},
        {"learn": "red", "box": [1, 2], "radius": 0},
        {"learn": "red", "box": [1, 2], "radius": 11},
        {"learn": "red", "box": [1, 2], "radius": "1"},
        {"learn": "red", "box": [1, 2], "radius": float("nan")},
        {"learn": "red", "box": [1, 2], "radius": float("inf")},
        {"learn": "red", "box": [1, 2]},
        {"write": False},
        {"write": "room.yaml"},
    ],
)
def test_nothing_of_another_form_is_learnt(asked: dict[str, Any]) -> None:
    with pytest.raises(FollowspotError, match="nothing that can be asked for"):
        request_of(json.dumps(asked))


def test_a_page_that_only_shows_learns_nothing(tmp_path: Path, room: str) -> None:
    operator = Operator(Page(compile_graph(GRAPH, room=room), make_gate(tmp_path), tmp_path))
    for asked in ({"still": "cam0"}, {"write": True}):
        assert "only shows" in operator.refused(**asked)

"""The page's process: what it shows, to whom, and what it does not let itself be told."""

from __future__ import annotations

import asyncio
import json
import os
import re
import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.tools.page.bundled import bundle
from tests.tools.page.page_socket import UPGRADE, things
from tests.tools.page.served import Shown, at, served, tracks
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from followspot.control.host import WorkerStatus
from followspot.control.stage_status import EdgeAge, PathStatus, StageStatus
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.operator.run_status import RunStatus
from followspot.ports.firing import firings_of
from followspot.tracking import Frame, Tracks
from followspot.wire import unpack
from followspot.worker.ledger import AWAY, COLUMNS, DELIVERED, DROPPED, LATE, PRODUCED, UNMATCHED
from followspot_dashboard.gate import WATCHED, make_gate
from followspot_dashboard.picture import picture_of
from followspot_page.page import MAX_BROWSERS, Page
from followspot_page.requests.handler import Requests
from followspot_record.embedded import plan_of_recording
from followspot_recording.recording import Recording
from followspot_recording.tap import RecordingTap

JUNK = [b"", b"x", bytes(70), b"\xff" * 70, b"a\0Tracks\0junk" * 100]
HELP = r"# (HELP|TYPE) followspot_\w+ .+"
SAMPLE = r'followspot_\w+(\{(\w+="[^"]*",?)+\})? [-+.e\d]+'


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    with served(tmp_path_factory.mktemp("run")) as made:
        yield made


def next_picture(browser: ClientConnection) -> bytes:
    while True:
        said = browser.recv(timeout=60)
        if isinstance(said, bytes):
            return said


def status(plan: Plan, fired: int = 7) -> RunStatus:
    counts = [0] * (COLUMNS * len(plan.edges))
    for column, count in {PRODUCED: 12, AWAY: 2, DELIVERED: 6, DROPPED: 1, LATE: 1, UNMATCHED: 1}.items():
        counts[column] = count
    age = EdgeAge(plan.edges[0].name, 4.5, 9.0, "too old")
    stage = StageStatus(
        "fuse", "sending", ("fuse.out -> track.positions",), 6, 1, 0, 1500.0, "it hurts", (age,)
    )
    worker = WorkerStatus(
        "main", "running", fired, stages=(stage,), paths=(PathStatus("camera", "save", 1.5, 9.0),)
    )
    return RunStatus((worker,), tuple(counts), fired, 100, ("a worker is back",))


def test_the_page_and_its_parts_are_there(page: Shown) -> None:
    bundle()
    code, text, headers = page.get("")
    assert code == 200
    assert "script-src 'self'" in headers["Content-Security-Policy"]
    parts = re.findall(r'(?:src|href)="/(static/[^"]+)"', text)
    assert len(parts) == 3
    for part in parts:
        assert page.get(part)[0] == 200, part
    code, text, headers = page.get("static/app.js")
    assert "javascript" in headers["Content-Type"]
    assert not re.search(r"(?:from|import)[\s(]*[\"']\.", text)  # it is one file


@pytest.mark.parametrize(
    "path", ["static/../server.py", "static/%2e%2e/server.py", "static//etc/passwd", "no"]
)
def test_no_other_file_is_served(page: Shown, path: str) -> None:
    assert page.get(path)[0] in (400, 404)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8777", "127.0.0.1:1", "", "a b", "[::"])
def test_a_request_under_another_name_is_refused(page: Shown, host: str) -> None:
    assert page.get("metrics", Host=host)[0] in (400, 403)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_page_of_another_site_sees_nothing(page: Shown, origin: str) -> None:
    with pytest.raises(InvalidStatus) as refused, page.look(origin):
        pass
    assert refused.value.response.status_code == 403
    assert page.get("status", Origin=origin)[0] == 403


def test_a_browser_is_told_the_room_first_and_then_what_is_new(page: Shown) -> None:
    with page.look(f"http://{page.host}") as browser:
        scene = next(things(browser, "scene"))
        assert [camera["name"] for camera in scene["room"]["cameras"]] == list(page.plan.room.cameras)
        assert [target["name"] for target in scene["room"]["targets"]] == list(page.plan.room.targets)
        page.send("track.tracks", at(40, tracks(1, 3)))
        view = next(things(browser, "view"))
    assert (view["kind"], view["time"], view["state"]) == ("Tracks", 40.0, ["tracked", "predicted"])
    assert view["xyz"][0] == [0.5, 0.25, 1.0]
    assert set(view["images"]) == set(page.plan.room.cameras)


def test_pictures_are_asked_for_only_while_a_browser_shows_them(page: Shown) -> None:
    with page.look() as browser:
        next(things(browser, "scene"))
        assert page.gate.words[WATCHED]
        picture = picture_of(at(80, Frame("cam1", np.zeros((24, 32, 1), "u1"))), 320)  # type: ignore[arg-type]
        assert picture is not None
        page.send("camera/cam1.out", picture)
        data = next_picture(browser)
    assert data.startswith(b"\x04cam1" + b"\x20\x00\x18\x00")
    assert data.endswith(picture.jpeg.tobytes())
    for _ in range(100):
        if not page.gate.words[WATCHED]:
            break
        page.get("status")  # the page needs a moment to notice
    assert not page.gate.words[WATCHED]


def resident(pid: int) -> int:
    """Memory of a process, bytes."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def test_a_browser_that_does_not_read_holds_up_no_other_and_takes_bounded_memory(page: Shown) -> None:
    """The stalled browser is sent nothing more after some pictures; the other one sees the newest ones."""
    noise = np.random.default_rng(0).integers(0, 255, (240, 320, 3), dtype="u1")
    picture = picture_of(at(0, Frame("cam0", noise)), 320)  # type: ignore[arg-type]
    assert picture is not None
    with socket.create_connection(page.host.split(":")) as stalled, page.look(max_size=None) as browser:  # type: ignore[arg-type]
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stalled.sendall(UPGRADE.format(host=page.host).replace("\n", "\r\n").encode())
        next(scene for scene in things(browser, "scene") if scene["forms"])  # it imports no more stages
        memory = []
        for number in range(500):
            page.send("camera/cam0.out", at(number, picture))
            if number % 3 == 2:
                page.send("track.tracks", at(number, tracks(1)))
                while next(things(browser, "view"))["seq"] != number:
                    continue
            memory.append(resident(page.pid) if number % 100 == 99 else 0)
    assert 500 * picture.jpeg.nbytes > 20e6  # what the stalled browser was not sent
    assert memory[-1] - memory[99] < 4e6


@pytest.mark.parametrize("junk", JUNK)
def test_what_is_no_preview_is_passed_over(page: Shown, junk: bytes) -> None:
    with socket.socket(socket.AF_UNIX) as stranger:
        stranger.connect(str(page.folder / "previews"))
        stranger.sendall(junk)
    with page.look() as browser:
        next(things(browser, "scene"))
        page.send("track.tracks", at(1, tracks(1)))
        assert next(things(browser, "view"))["kind"] == "Tracks"


def test_a_browser_that_says_too_much_is_let_go(page: Shown) -> None:
    bundle()
    with page.look() as browser:
        browser.send("x" * 5000)
        with pytest.raises(ConnectionClosed):
            list(things(browser, "nothing"))
    assert page.get("")[0] == 200


def test_a_parameter_is_set_and_a_stage_swapped_from_the_page(page: Shown) -> None:
    with page.look(f"http://{page.host}") as browser:
        scene = next(scene for scene in things(browser, "scene") if scene["forms"])
        assert set(scene["forms"]) == {
            "color",
            "infrared",
            "verify",
            "triangulate",
            "associate",
            "fuse",
            "bridge",
            "track",
        }
        fuse = scene["forms"]["fuse"]
        assert {"balls.mean_shift", "balls.mean", "balls.bundle"} <= set(fuse["alternatives"])
        assert not {"sinks.csv", "dashboard.tap", "balls.kalman"} & set(fuse["alternatives"])
        for change in ({"key": "maximum_iterations", "value": "50"}, {"key": "", "value": "balls.mean"}):
            browser.send(json.dumps({"stage": "fuse", **change}))
            assert next(things(browser, "answer"))["ok"]
        browser.send(json.dumps({"stage": "fuse", "key": "maximum_iterations", "value": "-1"}))
        answer = next(things(browser, "answer"))
    assert (answer["ok"], answer["text"]) == (False, "maximum_iterations must be at least 1")
    assert page.asked == [["fuse.maximum_iterations=50"], ["fuse=balls.mean"]]


@pytest.mark.parametrize(
    "said",
    [
        '{"type": "stop"}',
        "[" * 900,
        '{"stage": "save", "key": "path", "value": "/etc/passwd"}',
        '{"stage": "camera", "key": "frames", "value": "1"}',
        '{"stage": "fuse", "key": "", "value": "sinks.csv"}',
        '{"stage": "fuse", "key": "uses", "value": "balls.mean"}',
        '{"stage": ["fuse"], "key": "maximum_iterations", "value": "1"}',
        '{"stage": "nobody", "key": "maximum_iterations", "value": "1"}',
        '{"open": "another run"}',
        '{"seek": 1e308, "play": true}',
        '{"plot": [{"port": "nobody.out", "row": "", "field": "z"}]}',
        '{"plot": [[], {}]}',
        '{"still": "nobody"}',
        '{"still": "cam1"}',
        '{"learn": "red", "box": [1, 2], "radius": 1}',
        '{"learn": "red", "box": [99999999999999999999, 2], "radius": 1}',
        '{"learn": "../../etc/passwd", "box": [1, 2], "radius": 1}',
        '{"write": true}',
        "nul",
        "1" * 4000,
    ],
)
def test_nothing_else_can_be_asked_for(page: Shown, said: str) -> None:
    before = list(page.asked)
    with page.look() as browser:
        next(scene for scene in things(browser, "scene") if scene["forms"])
        browser.send(said)
        assert not next(things(browser, "answer"))["ok"]
    assert page.asked == before


def recordings(browser: ClientConnection, state: str) -> dict[str, Any]:
    return next(about for about in things(browser, "recording") if about["state"] == state)


def test_chosen_ports_are_recorded_from_the_page_and_what_is_missing_is_counted(page: Shown) -> None:
    with page.look(f"http://{page.host}") as browser:
        scene = next(scene for scene in things(browser, "scene") if scene["ports"])
        assert scene["ports"][0] == "camera"
        assert set(scene["ports"]) == {"camera", *scene["forms"]}
        browser.send(json.dumps({"on": True, "ports": "track.tracks,color/cam0"}))
        assert next(things(browser, "answer"))["ok"]
        assert set(page.recorded) == {
            "track.tracks",
            "color/cam0.out",
            firings_of("track"),
            firings_of("color/cam0"),
        }
        tap = RecordingTap(**page.recorded["track.tracks"])
        tap.setup()
        for ms in (10, 20, 30):
            tap.process(at(ms, tracks(1, 0)))
        tap.number += 2  # as if two had found no room
        tap.process(at(60, tracks(1)))
        next(about for about in things(browser, "recording") if about["messages"] == 4)
        browser.send(json.dumps({"on": True}))
        assert "recorded already" in next(things(browser, "answer"))["text"]
        browser.send(json.dumps({"on": False}))
        told = recordings(browser, "over")
        assert next(things(browser, "answer"))["ok"]
    tap.close()
    assert (told["messages"], told["lost"], told["error"]) == (4, 2, "")
    path = Path(told["file"])
    assert (path.parent, told["bytes"]) == (page.out, path.stat().st_size)
    with Recording(path) as recording:
        assert plan_of_recording(recording).stages == page.plan.stages
        assert recording.metadata["moment"] == "true"
        found = [unpack(bytes(message.data), Tracks) for message in recording.messages("track.tracks")]
    assert [message.header.time for message in found if isinstance(message, Tracks)] == [
        ms * 1_000_000 for ms in (10, 20, 30, 60)
    ]


@pytest.mark.parametrize("said", ['{"on": false}', '{"on": true, "ports": "nobody"}', '{"on": 1}'])
def test_what_cannot_be_recorded_is_answered(page: Shown, said: str) -> None:
    with page.look() as browser:
        next(scene for scene in things(browser, "scene") if scene["ports"])
        browser.send(said)
        assert not next(things(browser, "answer"))["ok"]


def test_there_is_a_most_of_browsers(page: Shown) -> None:
    with ExitStack() as stack:
        for _ in range(MAX_BROWSERS):
            next(things(stack.enter_context(page.look()), "scene"))
        with pytest.raises(ConnectionClosed) as refused:
            list(things(stack.enter_context(page.look()), "scene"))
    assert refused.value.rcvd is not None
    assert refused.value.rcvd.code == 1013
    assert refused.value.rcvd.reason.startswith(f"{MAX_BROWSERS} browsers show this page")


def test_status_and_metrics_tell_the_ledger(page: Shown) -> None:
    page.send("track.tracks", at(5, tracks(1)))
    with page.look() as browser:
        page.status = status(page.plan)
        run = next(run for run in things(browser, "run") if run["fired"] == 7)
    assert {stage["stage"]: stage["error"] for stage in run["stages"]}["fuse"] == "it hurts"
    first = run["edges"][0]
    assert (first["produced"], first["away"], first["sent"], first["in_flight"]) == (12, 2, 10, 1)
    assert (first["dropped"], first["p50_ms"], first["p95_ms"], first["error"]) == (1, 4.5, 9.0, "too old")
    assert run["edges"][1]["p50_ms"] is None
    assert json.loads(page.get("status")[1])["news"] == ["a worker is back"]
    code, text, headers = page.get("metrics")
    assert (code, headers["Content-Type"]) == (200, "text/plain; version=0.0.4; charset=utf-8")
    samples = dict(re.findall(r"^([a-z_]+(?:\{.*\})?) (\S+)$", text, re.MULTILINE))
    edge = page.plan.edges[0]
    ends = f'from="{edge.from_stage}.{edge.from_port}",to="{edge.to_stage}.{edge.to_port}"'
    became = [float(v) for k, v in samples.items() if k.startswith(f"followspot_edge_messages{{{ends},")]
    assert sum(became) == float(samples[f"followspot_edge_produced_total{{{ends}}}"]) == 12
    assert samples[f"followspot_edge_sent_total{{{ends}}}"] == "10"
    assert samples['followspot_target_state{target="green",state="tracked"}'] == "1"
    assert samples['followspot_target_state{target="red",state="lost"}'] == "1"
    assert samples['followspot_path_latency_seconds{from="camera",to="save",quantile="0.95"}'] == "0.009"
    assert samples[f'followspot_edge_age_seconds{{{ends},quantile="0.95"}}'] == "0.009"
    for line in text.splitlines():
        assert re.fullmatch(f"{HELP}|{SAMPLE}", line), line


def test_a_page_that_is_open_to_other_computers_only_shows(page: Shown, tmp_path: Path) -> None:
    open_page = Page(page.plan, make_gate(tmp_path), tmp_path)  # never told that changes are allowed
    about = open_page.about()
    assert (about["forms"], about["ports"]) == ({}, [])
    for wish in (
        '{"stage": "fuse", "key": "maximum_iterations", "value": "50"}',
        '{"on": true}',
        '{"on": false}',
    ):
        with pytest.raises(FollowspotError, match="only shows"):
            asyncio.run(Requests(open_page).do(wish))

"""Watching a run does not change it: same tracks, same ledger, and no process of the page stays."""

from __future__ import annotations

import json
import re
import signal
import socket
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from mcap.reader import make_reader
from tests.commands import Started, launch
from tests.core.worker.solo import Solo
from tests.integration.hosts import Agent, near_agent
from tests.tools.own_ball import middle, pick, room_for
from tests.tools.page.browser import CHROMIUM, Browser, browser
from tests.tools.page.bundled import bundle
from websockets.sync.client import ClientConnection, connect

from followspot.graph.compile import compile_graph
from followspot.operator.reporting.report import RunReport
from followspot.ports.firing import FIRINGS
from followspot.room_file import load
from followspot.worker.ledger import EdgeCount
from followspot_dashboard.gate import SOCKET, make_gate
from followspot_page.taps.shown_ports import shown_ports, tappings
from followspot_recording.recording import Recording

ROOT = Path(__file__).parents[2]
GRAPH = ROOT / "graphs" / "glowballs.yaml"
FRAMES = 12
UPGRADE = (
    "GET /look HTTP/1.1\r\nHost: {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


@dataclass(frozen=True)
class Done:
    """The results of a run: its ledger, and the bytes of its tracks."""

    edges: tuple[tuple[str, EdgeCount], ...]
    tracks: bytes

    @classmethod
    def by(cls, report: RunReport, out: Path) -> Done:
        assert report.ok, report.errors
        edges = tuple((edge.name, count) for edge, count in report.edges)
        return cls(edges, (out / "tracks.csv").read_bytes())


def demo(out: Path) -> Solo:
    return Solo(compile_graph(GRAPH), out, FRAMES)


@pytest.fixture(scope="module")
def unwatched(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """A run without a page."""
    out = tmp_path_factory.mktemp("unseen")
    return Done.by(demo(out).run(), out)


@pytest.fixture
def room_for_sockets() -> Iterator[Path]:
    """A folder with a short name: the path of a socket has at most 107 bytes."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


@pytest.fixture
def agent(tmp_path: Path) -> Iterator[Agent]:
    """The agent of another host, on this machine."""
    home = tmp_path / "pc-left"
    home.mkdir()
    made = near_agent("pc-left", home)
    yield made
    made.end()


@contextmanager
def stalled(host: str) -> Iterator[None]:
    """A browser that requests all pictures and reads nothing."""
    name, _, port = host.rpartition(":")
    with socket.socket() as page:
        page.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        page.connect((name, int(port)))
        page.sendall(UPGRADE.format(host).encode())
        yield


def told(page: ClientConnection, kind: str, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """The first message of this kind that fits."""
    limit = time.monotonic() + 120.0
    while True:
        assert time.monotonic() < limit, f"no {kind} as wanted came"
        said = page.recv(timeout=60)
        if isinstance(said, str):
            thing: dict[str, Any] = json.loads(said)
            if thing["type"] == kind and fits(thing):
                return thing


def cameras_seen(page: ClientConnection) -> set[str]:
    """Cameras of the first pictures, until each of the six has sent one and changes are possible."""
    seen: set[str] = set()
    changes = False
    while len(seen) < 6 or not changes:
        said = page.recv(timeout=60)
        if isinstance(said, bytes):
            seen.add(said[1 : 1 + said[0]].decode())
        elif (thing := json.loads(said))["type"] == "scene":
            changes = bool(thing["ports"])
    return seen


@contextmanager
def watched(out: Path, *options: str, graph: Path = GRAPH) -> Iterator[tuple[Started, str]]:
    """A run with a page, and the page's address."""
    bundle()
    words = ["run", graph, "--json", "--out", out, "--dashboard-at", "127.0.0.1:0", *options]
    with launch(*words) as process:
        try:
            line = process.stderr.readline()
            found = re.search(r"http://\S+/", line)
            assert found, line
            rest: list[str] = []
            reading = threading.Thread(target=lambda: rest.extend(process.stderr), daemon=True)
            reading.start()
            yield process, found[0]
            reading.join(timeout=60)
            said = "".join(rest).strip()  # a slow machine cannot score all frames of a run without end
            assert not said or "more were to come" in said
        finally:
            process.kill()


def test_unread_previews_change_neither_ledger_nor_tracks(
    tmp_path: Path, room_for_sockets: Path, unwatched: Done
) -> None:
    """A browser requests 60 pictures a second and reads none: taps do not wait for it."""
    make_gate(room_for_sockets).watched = True
    with socket.socket(socket.AF_UNIX) as page:
        page.bind(str(room_for_sockets / SOCKET))
        page.listen(64)
        run = demo(tmp_path)
        run.tap(tappings(shown_ports(run.plan), room_for_sockets, rate=60.0))
        taps = [
            tap for runner in run.scheduler.runners for _, output in runner.outputs for tap in output.taps
        ]
        assert len(taps) == 14  # six cameras, six detectors, tracks and forecasts
        assert Done.by(run.run(), tmp_path) == unwatched


def written(file: Path) -> list[tuple[str, int]]:
    """Topic and number of each message as it was sent, in the order of a recording."""
    with file.open("rb") as opened:
        found = make_reader(opened).iter_messages(log_time_order=False)
        return [(c.topic, m.sequence) for _, c, m in found if c.topic.startswith("/followspot/")]


def gaps(numbers: list[tuple[str, int]]) -> int:
    """How many numbers are missing between the first and the last of each topic."""
    by_topic: dict[str, list[int]] = {}
    for topic, number in numbers:
        by_topic.setdefault(topic, []).append(number)
    return sum(found[-1] + 1 - found[0] - len(found) for found in by_topic.values())


@pytest.mark.thorough
def test_a_watched_run_on_two_hosts_is_the_same_and_the_page_ends_with_it(
    tmp_path: Path, room_for_sockets: Path, unwatched: Done, agent: Agent, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One browser watches and records, one has stalled; half of the cameras are on another host."""
    placement = tmp_path / "two.yaml"
    placement.write_text("workers: {left: {host: pc-left, cameras: [cam0, cam1, cam2]}}\n")
    monkeypatch.setenv("TMPDIR", str(room_for_sockets))
    options = ("--quiet", "--placement", str(placement), "--connect", agent.endpoint)
    with watched(tmp_path, *options) as (process, url), ExitStack() as browsers:
        host = urlsplit(url).netloc
        browsers.enter_context(stalled(host))
        looking = browsers.enter_context(connect(f"ws://{host}/look", max_size=None, proxy=None))
        assert cameras_seen(looking) == set(compile_graph(GRAPH).room.cameras)
        looking.send(json.dumps({"on": True, "ports": "track.tracks,color,camera/cam0"}))
        recorded = told(looking, "recording", lambda about: about["messages"] > 5 * FRAMES)
        status = json.load(urlopen(url + "status", timeout=60))
        while status["fired"] <= FRAMES or not status["paths"]:
            time.sleep(0.1)
            status = json.load(urlopen(url + "status", timeout=60))
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=120)
    with pytest.raises(OSError, match="refused"):
        urlopen(url, timeout=5)
    assert not list(room_for_sockets.glob("followspot-page-*"))
    summary = json.loads(out)
    assert summary["ok"]
    assert all(edge["dropped"] == edge["invalid"] == edge["in_flight"] == 0 for edge in summary["edges"][:6])
    with Recording(recorded["file"]) as recording:
        assert not recording.problem  # it was complete when its run had ended
        kept = {port: sum(1 for _ in recording.messages(port)) for port in recording.ports}
    assert set(kept) == {"track.tracks", "camera/cam0.out", *(f"color/cam{i}.out" for i in (0, 2, 5))}
    assert all(count > 5 for count in kept.values()), kept  # color/cam0 and color/cam2 are on the other host
    assert sum(kept.values()) >= recorded["messages"]
    numbers = written(Path(recorded["file"]))
    messages = [place for place, (topic, _) in enumerate(numbers) if not topic.endswith(FIRINGS)]
    then = numbers[: messages[recorded["messages"] - 1] + 1]
    assert gaps(then) <= recorded["lost"] <= gaps(numbers)  # a busy machine drops at a tap, and tells it
    assert [edge["from"] for edge in status["edges"]] == [edge["from"] for edge in summary["edges"]]
    assert all(
        now["sent"] <= then["sent"] for now, then in zip(status["edges"], summary["edges"], strict=True)
    )
    assert {path["sink"] for path in status["paths"]} == {"save"}
    assert (tmp_path / "tracks.csv").read_bytes().startswith(unwatched.tracks)


def test_ports_that_are_not_shown_are_tapped_while_a_plot_shows_them(tmp_path: Path) -> None:
    endless = ("--quiet", "--set", "camera.frames=0")
    with watched(tmp_path, *endless) as (process, url):
        with connect(f"ws://{urlsplit(url).netloc}/look", max_size=None, proxy=None) as looking:
            figures = told(looking, "scene", lambda scene: bool(scene["forms"]))["figures"]
            port = next(port for port in figures["ports"] if port.startswith("triangulate."))
            fields = [field["name"] for field in figures["kinds"][figures["ports"][port]]["fields"]]
            wanted = [{"port": port, "row": "0", "field": field} for field in ("rows", fields[0])]
            looking.send(json.dumps({"plot": wanted}))
            assert told(looking, "answer", lambda _: True)["ok"]
            plotted = told(looking, "curves", lambda told: told["values"][0][2] > 0)
            assert (plotted["port"], len(plotted["values"])) == (port, 2)
            assert isinstance(plotted["values"][1][2], float)
            looking.send(json.dumps({"plot": []}))
            assert told(looking, "answer", lambda _: True)["ok"]
            looking.send(json.dumps({"plot": wanted[:1]}))  # once more, and the tab is closed
            assert told(looking, "answer", lambda _: True)["ok"]
        with connect(f"ws://{urlsplit(url).netloc}/look", max_size=None, proxy=None) as looking:
            told(looking, "run", lambda run: run["fired"] > 0 and not run["faults"])
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_browser_shows_pictures_room_and_graph_and_holds_a_replay(tmp_path: Path) -> None:
    endless = ("--set", "camera.frames=0")  # however long the browser takes to begin
    with (
        watched(tmp_path / "run", "--quiet", *endless) as (process, url),
        browser(tmp_path / "chromium") as chromium,
    ):
        chromium.open(url, 390, 844)
        chromium.wait("document.querySelectorAll('figure:not(.dark)').length === 6")
        chromium.wait("document.querySelector('#legend li').dataset.state === 'tracked'")
        chromium.wait("document.querySelector('#life').dataset.life === 'running'")
        assert chromium.ask("document.documentElement.scrollWidth") <= 390  # nothing sticks out of a phone
        chromium.ask("document.querySelector('#pipeline button').focus()")
        chromium.press("Enter")
        chromium.wait("document.querySelectorAll('#detail td').length > 20")
        assert chromium.ask("document.querySelector('#detail h2').textContent") == "camera · sim.camera"
        pause_step_and_resume(chromium)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        chromium.wait("document.querySelector('#life').dataset.life === 'ended'")
        assert [error for error in chromium.errors if "ERR_CONNECTION" not in error] == []


def pause_step_and_resume(chromium: Browser) -> None:
    """By the buttons of the page."""
    toggle, step, status = (f"document.querySelector('#player').children[{i}]" for i in range(3))
    chromium.wait("!document.querySelector('#player').hidden")
    chromium.ask(f"{toggle}.click()")
    chromium.wait("document.querySelector('#life').dataset.life === 'paused'")
    chromium.wait(f"{toggle}.textContent === 'resume'")
    for _ in range(2):
        before = chromium.ask(f"{status}.textContent")
        chromium.ask(f"{step}.click()")
        reached = f"{status}.textContent"
        chromium.wait(f"{reached}.startsWith('at ') && {reached} !== {json.dumps(before)}")
    places = "[...document.querySelectorAll('#player button, #record')].map(b => b.getBoundingClientRect())"
    beside = "(!i || all[i - 1].right <= p.left || all[i - 1].bottom <= p.top)"
    assert chromium.ask(f"{places}.every((p, i, all) => {beside})")  # none overlaps
    chromium.ask(f"{toggle}.click()")
    chromium.wait("document.querySelector('#life').dataset.life === 'running'")


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_ball_is_learnt_by_a_click_and_a_figure_of_its_blobs_is_plotted(tmp_path: Path) -> None:
    room = Path(room_for(tmp_path))
    assert pick(str(room), "red={},{}".format(*middle(6))) == 0
    room.write_text(room.read_text().replace("cameras.video", "cameras.playback"))
    options = ("--quiet", "--room", str(room), "--set", "camera.loop=true")
    graph = ROOT / "graphs" / "single_camera.yaml"
    with (
        watched(tmp_path / "out", *options, graph=graph) as (process, url),
        browser(tmp_path / "chromium") as chromium,
    ):
        chromium.open(url, 1280, 800)
        chromium.wait("document.querySelectorAll('body.learns figure:not(.dark)').length === 1")
        chromium.ask("document.querySelector('.learn').click()")
        chromium.wait("!document.querySelector('#picker canvas').hidden")
        for number, text in enumerate(("blue", "0.05")):
            field = f"document.querySelectorAll('#picker input')[{number}]"
            chromium.ask(f"{field}.value = '{text}'; {field}.dispatchEvent(new Event('change'))")
        left, top, scale = json.loads(
            chromium.ask(
                "(() => { const c = document.querySelector('#picker canvas'), r = c.getBoundingClientRect();"
                " return JSON.stringify([r.left, r.top, r.width / c.width]) })()"
            )
        )
        for kind in ("mousePressed", "mouseReleased"):  # on the ball that rests
            place = {"x": left + scale * 30.5, "y": top + scale * 30.5, "button": "left", "clickCount": 1}
            chromium.call("Input.dispatchMouseEvent", type=kind, **place)
        chromium.wait("document.querySelectorAll('.learnt li').length === 5")
        assert set(load(room).targets) == {"red"}
        chromium.ask("document.querySelector('#picker .write').click()")
        chromium.wait("/blue is in/.test(document.querySelector('#picker [role=status]').textContent)")
        assert load(room).targets["blue"].radius == 0.05
        chromium.ask("document.querySelector('#picker .close').click()")
        chromium.ask("document.querySelector('#over').click()")
        port, field = (
            f"document.querySelector('.curves select[aria-label={name}]')" for name in ("port", "field")
        )
        chromium.ask(f"{port}.value = 'color/cam0.out'; {port}.dispatchEvent(new Event('change'))")
        chromium.ask(f"{field}.value = 'rows'; document.querySelector('.curves').requestSubmit()")
        chromium.wait("!!document.querySelector('.plot:has(button) polyline')")
        assert chromium.errors == []
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


@pytest.mark.thorough
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_an_operator_finds_a_wrong_parameter_on_the_page_and_mends_it(tmp_path: Path) -> None:
    """Nothing is tracked; the cards say that blobs are found and pairs are not; a reset brings the tracks."""
    planted = (
        "-q",
        "--set",
        "camera.realtime=true",
        "--set",
        "camera.frames=0",
        "--set",
        "color.similarity=1.0",
    )
    with watched(tmp_path / "out", *planted) as (process, url), browser(tmp_path / "chromium") as chromium:
        chromium.open(url, 1280, 800)
        chromium.wait("document.querySelectorAll('figure:not(.dark)').length === 6")
        assert not chromium.ask("document.querySelectorAll('#legend li[data-state=tracked]').length")
        card = "[...document.querySelectorAll('#pipeline button')].find(b => /^color/.test(b.innerText))"
        chromium.ask(f"{card}.click()")
        fields = "[...document.querySelectorAll('#detail .field')]"
        field = f"{fields}.find(f => /^similarity/.test(f.innerText))"
        chromium.wait(f"!!{field}")
        value = f"{field}.querySelector('input[inputmode=decimal]')"
        assert chromium.ask(f"{value}.value") == "1"
        default = re.search(r"([\d.]+) by default", chromium.ask(f"{field}.innerText"))
        assert default is not None
        chromium.ask(
            f"{value}.value = '{default[1]}'; {value}.dispatchEvent(new Event('change', {{bubbles: true}}))"
        )
        chromium.wait(f"{field}.querySelector('.answer').dataset.ok === 'true'")
        chromium.wait("document.querySelectorAll('#legend li[data-state=tracked]').length === 3")
        chromium.ask("document.querySelector('#over').click()")
        chromium.wait("/color: .*similarity/.test(document.querySelector('.log').innerText)")
        process.send_signal(signal.SIGINT)
        process.wait(60)

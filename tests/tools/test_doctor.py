"""Whatever is wrong is named, with a remedy; each problem here is a real one."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from tests.commands import COMMAND
from tests.integration.hosts import near_agent

from followspot.cli.main import main
from followspot.control.host import HostLost
from followspot.host.clocks.host import HostClock
from followspot.security.authority import create_authority
from followspot_doctor.checks.hosts import _clock, certificates
from followspot_doctor.checks.network import PORTS

ROOT = Path(__file__).parent.parent.parent
ROOM = ROOT / "graphs" / "rooms" / "simulated.yaml"
UNSHARED = ("unshare", "--map-root-user", "--net")
"""A network of its own, with nothing up."""


@dataclass(frozen=True)
class Told:
    """What the doctor said: exit code, and findings by subject."""

    code: int
    findings: Mapping[str, dict[str, str]]

    def bad(self, subject: str) -> str:
        """The text of a problem or warning."""
        found = self.findings[subject]
        assert found["state"] in ("problem", "warning"), found
        assert found["remedy"]
        return found["text"]


def doctor(
    folder: Path, *words: object, path: Path | None = None, files: int = 1024, inside: tuple[str, ...] = ()
) -> Told:
    """folder: where it stands; path: one with more packages; files: that may be open; inside: runs it."""
    limited = ("sh", "-c", 'ulimit -n "$0" && exec "$@"', str(files))  # no code of a process with threads
    done = subprocess.run(
        [*inside, *limited, *COMMAND, "doctor", "--json", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(path)} if path else None,
    )
    assert done.stdout, done.stderr
    return told(done.returncode, done.stdout)


def told(code: int, output: str) -> Told:
    """What stands in the output of `followspot doctor --json`."""
    findings = json.loads(output)["findings"]
    bad = [f["subject"] for f in findings if f["state"] != "ok"]
    assert len(set(bad)) == len(bad)
    return Told(code, {f["subject"]: f for f in findings})


@pytest.fixture
def here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Told]:
    """The doctor in this process, which has imported many stages, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def doctor(*words: object) -> Told:
        code = main(["doctor", "--json", *map(str, words)])
        return told(code, capsys.readouterr().out)

    return doctor


def install(site: Path, name: str, entries: str, module: str) -> None:
    """A distribution with one module."""
    info = site / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(entries)
    (site / f"{name}.py").write_text(module)


def room_with(folder: Path, sources: dict[str, dict[str, Any] | None]) -> Path:
    """A room of such cameras, otherwise like cam0 of the simulated one."""
    cam0 = yaml.safe_load(ROOM.read_text())["cameras"]["cam0"]
    del cam0["source"]
    cameras = {name: {**cam0, **({"source": use} if use else {})} for name, use in sources.items()}
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump({"cameras": cameras}))
    return file


def take_one(server: socket.socket, ports: Iterable[int]) -> None:
    """Bind to the first port that no other program of this host has."""
    for port in ports:
        try:
            server.bind(("127.0.0.1", port))
        except OSError:
            continue
        return
    raise AssertionError("all ports are taken by other programs")


@pytest.fixture(scope="module")
def ill(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Told]:
    """A computer, a room and a graph with every problem at once."""
    folder = tmp_path_factory.mktemp("ill")
    site = folder / "site"
    install(site, "numb", "[followspot.plugins.v1]\nnumb.horn = numb:Horn\n", "import no_such_thing\n")
    install(site, "double", "[followspot.plugins.v1]\nballs.kalman = double:Horn\n", "")
    install(site, "torn", "[followspot.hooks.v1]\ntorn = torn\n", "raise RuntimeError('out of tune')\n")
    (folder / "file").write_text("")
    (folder / "noise.mkv").write_bytes(b"no video at all" * 100)
    (folder / "large").mkdir()
    assert cv2.imwrite(str(folder / "large" / "0000.png"), np.zeros((480, 640, 3), np.uint8))
    graph = folder / "graph.yaml"
    graph.write_text("stages: {track: {uses: sinks.csvv, in: {tracks: fuse}}}\n")
    with socket.socket() as silent, socket.socket() as server:
        silent.bind(("127.0.0.1", 0))
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        take_one(server, PORTS)
        server.listen()
        sources: dict[str, dict[str, Any] | None] = {
            "gone": {"uses": "cameras.video", "with": {"path": "gone.mkv"}},
            "noise": {"uses": "cameras.video", "with": {"path": "noise.mkv"}},
            "large": {"uses": "cameras.images", "with": {"path": "large", "fps": 30}},
            "unplugged": {"uses": "cameras.device", "with": {"device": "/dev/video77"}},
            "silent": {
                "uses": "cameras.stream",
                "with": {"url": f"rtsp://127.0.0.1:{silent.getsockname()[1]}/cam"},
            },
            "misspelt": {"uses": "cameras.vidoe"},
            "bare": None,
        }
        words = ("--room", room_with(folder, sources), "--graph", graph, "--out", folder / "file" / "runs")
        yield doctor(folder, *words, "--certificates", folder / "none", path=site, files=200)


def test_a_sound_computer_room_and_graph_have_no_problem(here: Callable[..., Told]) -> None:
    told = here("--room", ROOM, "--graph", ROOT / "graphs" / "glowballs.yaml")
    assert {f["text"] for f in told.findings.values() if f["state"] == "problem"} == set()
    assert told.code == 0
    assert "no GPU" in told.findings["computer"]["text"]


def test_a_depth_camera_says_how_much_it_measures(here: Callable[..., Told]) -> None:
    told = here("--room", ROOT / "graphs/rooms/simulated_depth.yaml")
    for name in ("depth0", "depth1"):
        assert told.findings[name]["state"] == "ok"
        assert "sim.depth_camera: 320x240, " in told.findings[name]["text"]
        assert "% of the pixels measured" in told.findings[name]["text"]


SENSORS = """\
room: sensors
sensors:
  green: {kind: imu, rate: 200, mount: {target: ball}, source: {uses: sim.imu, with: {frames: 60}}}
  slow: {kind: imu, rate: 1000, source: {uses: imu.csv, with: {path: slow.csv}}}
  away: {kind: imu, host: pc-left, source: {uses: sim.imu}}
  bare: {kind: imu}
  odd: {kind: imu, source: {uses: sim.imuu}}
targets: {ball: {radius: 0.0762}}
"""


def test_a_sensor_says_what_it_sends_and_how_often(tmp_path: Path, here: Callable[..., Told]) -> None:
    (tmp_path / "room.yaml").write_text(SENSORS)
    rows = "".join(f"{n / 50},0,0,0,0,0,9.8\n" for n in range(100))
    (tmp_path / "slow.csv").write_text(f"time,gx,gy,gz,ax,ay,az\n{rows}")
    found = here("--room", tmp_path / "room.yaml").findings
    said = {name: (one["state"], one["text"]) for name, one in found.items() if f"  {name}:" in SENSORS}
    assert said == {
        "green": ("ok", "sim.imu: Inertial, 200 readings/s"),
        "slow": ("warning", "imu.csv: Inertial, 50 readings/s, and the room says 1000"),
        "away": ("ok", "is on pc-left: run followspot doctor there"),
        "bare": ("problem", "has no source"),
        "odd": ("problem", 'no stage "sim.imuu" is installed'),
    }


@pytest.mark.parametrize(
    ("subject", "said"),
    [
        ("stage numb.horn", "no_such_thing"),
        ("stage balls.kalman", "offered by both"),
        ("commands of torn", "out of tune"),
        ("open files", "200 at a time"),
        ("output folder", "cannot be written"),
        ("certificates", "ca.pem is missing"),
        ("gone", "gone.mkv does not exist"),
        ("noise", "noise.mkv"),
        ("large", "640x480 px, but camera large is calibrated for 320x240"),
        ("unplugged", "/dev/video77"),
        ("silent", "127.0.0.1"),
        ("misspelt", 'no stage "cameras.vidoe"'),
        ("bare", "has no source"),
    ],
)
def test_a_problem_is_named_with_a_remedy(ill: Told, subject: str, said: str) -> None:
    assert said in ill.bad(subject)
    assert ill.code == 1


def test_a_port_that_is_taken_is_named_with_a_remedy(ill: Told) -> None:
    taken = [subject for port in PORTS if ill.findings[subject := f"port {port}"]["state"] != "ok"]
    assert taken
    assert {ill.bad(subject) for subject in taken} == {"is taken"}


def test_stages_of_a_file_are_known_to_graph_and_room(tmp_path: Path) -> None:
    (tmp_path / "bars.py").write_text(
        "import numpy as np\n"
        "from followspot import Source, Stage, at\n"
        "from followspot.tracking import Frame\n"
        "class Film(Stage):\n"
        "    def process(self) -> Source[Frame]:\n"
        "        yield at(0, Frame('left', np.zeros((240, 320, 3), np.uint8)))\n"
        "class Look(Stage):\n"
        "    def process(self, frame: Frame) -> None: ...\n"
    )
    (tmp_path / "graph.yaml").write_text(
        "stages:\n"
        "  camera: {uses: room.source, each: cameras}\n"
        "  look: {uses: bars.look, each: cameras, in: {frame: camera}}\n"
    )
    words = (
        "--room",
        room_with(tmp_path, {"left": {"uses": "bars.film"}}),
        "--graph",
        tmp_path / "graph.yaml",
    )
    told = doctor(tmp_path, *words, "--plugin", tmp_path / "bars.py")
    assert told.findings["graph"]["state"] == "ok", told.findings
    assert told.findings["left"]["state"] == "ok", told.findings


def test_a_mistake_in_the_graph_is_named_with_its_place(ill: Told) -> None:
    places = [subject for subject in ill.findings if "graph.yaml:1:" in subject]
    assert any("sinks.csvv" in ill.bad(place) for place in places)


def test_a_computer_without_network_agents_and_the_right_opencv(tmp_path: Path) -> None:
    if not shutil.which("unshare") or subprocess.run([*UNSHARED, "true"], check=False).returncode:
        pytest.skip("network namespaces are not permitted here")
    (tmp_path / "cv2.py").write_text(
        "__version__ = '5.0.0'\nclass videoio_registry:\n    getBackends = list\n"
    )
    told = doctor(tmp_path, "--connect", "tcp/127.0.0.1:7450", path=tmp_path, inside=UNSHARED)
    assert told.code == 1
    assert told.bad("agents") == "none answers at tcp/127.0.0.1:7450"
    assert "does not arrive" in told.bad("loopback")
    assert "does not come back" in told.bad("multicast")
    assert told.bad("opencv") == "OpenCV 5.0.0 has no HOG detector"


def test_a_host_whose_clock_is_off(tmp_path: Path, here: Callable[..., Told]) -> None:
    agent = near_agent("pc-left", tmp_path, "--clock-offset", "80")
    try:
        told = here("--connect", agent.endpoint)
    finally:
        agent.end()
    assert "ms ahead of this one" in told.bad("host pc-left")
    assert told.code == 0


def test_a_host_that_is_busy_for_a_moment_tells_its_clock_all_the_same() -> None:
    class Busy:
        asked = 0

        def ask(self, agent: str, verb: str, timeout: float) -> dict[str, int]:
            self.asked += 1
            if self.asked == 1:
                raise HostLost(f"host {agent} does not answer")
            return HostClock(known=80_000_000).read()

    assert "ms ahead of this one" in _clock(Busy(), "pc-left").text  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("days", "state", "said"),
    [(-1, "problem", "expired"), (3, "warning", "of pc-left"), (99, "ok", "of pc-left")],
)
def test_a_certificate_that_ends_soon(tmp_path: Path, days: int, state: str, said: str) -> None:
    folder = create_authority(tmp_path / "certs").add("pc-left", "camera")
    expires = (datetime.now(UTC) + timedelta(days=days)).isoformat()
    hosts = {"pc-left": {"role": "camera", "expires": expires}}
    (folder / "hosts.json").write_text(json.dumps({"format": 1, "own": "pc-left", "hosts": hosts}))
    (found,) = certificates(folder)
    assert found.state == state
    assert said in found.text


def test_the_text_counts_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = tmp_path / "room.yaml"
    room.write_text(ROOM.read_text().replace("size: [320, 240]", "size: [320]", 1))
    assert main(["doctor", "--room", str(room), "--out", str(tmp_path)]) == 1
    text = capsys.readouterr().out
    assert f"PROBLEM  room {room}:" in text
    assert "1 problem" in text.splitlines()[-1]

"""A newcomer in a bare environment: a wheel, an empty folder, and what the documents say."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.packages import build
from tests.tools.page.bundled import bundle
from websockets.sync.client import connect

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.thorough


class Newcomer:
    """Someone with an environment of their own, in a folder of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "home"
        self.folder.mkdir()
        self.programs = folder / "environment" / "bin"
        venv.create(folder / "environment", with_pip=True)
        kept = {name: text for name, text in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL"))}
        self.environment = kept | {"PATH": f"{self.programs}:{os.environ['PATH']}"}

    def types(self, line: str, folder: str = ".") -> str:
        """What a command says. It has to succeed."""
        where = self.folder / folder
        done = subprocess.run(
            line, shell=True, cwd=where, env=self.environment, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
        return done.stdout + done.stderr

    @contextmanager
    def started(self, *words: str, folder: str = ".") -> Iterator[subprocess.Popen[str]]:
        """A run that goes on meanwhile."""
        command = [str(self.programs / "followspot"), *words]
        with subprocess.Popen(
            command, cwd=self.folder / folder, env=self.environment, stderr=subprocess.PIPE, text=True
        ) as process:
            try:
                yield process
            finally:
                process.kill()


@pytest.fixture(scope="module")
def newcomer(tmp_path_factory: pytest.TempPathFactory) -> Newcomer:
    """With the wheel and the extras of the page and of recordings."""
    folder = tmp_path_factory.mktemp("newcomer")
    made = Newcomer(folder)
    bundle()
    wheel = build("wheel", ROOT, folder / "wheel")
    try:
        made.types(f"pip install --quiet {wheel}")
    except AssertionError as error:
        pytest.skip(f"packages cannot be installed: {str(error)[-200:]}")
    return made


def test_a_fresh_install_is_sound_and_has_the_demo(newcomer: Newcomer) -> None:
    assert "PROBLEM" not in newcomer.types("followspot doctor")
    assert re.search(r"blue +\d+ +\d+\.\d %", newcomer.types("followspot demo --frames 60 --out demo"))
    assert (newcomer.folder / "demo" / "tracks.csv").read_text().count("\n") > 60


def test_own_ball_in_own_video_in_five_commands(newcomer: Newcomer) -> None:
    writer = cv2.VideoWriter(
        str(newcomer.folder / "balls.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, (200, 150)
    )
    for frame in range(12):
        picture = np.full((150, 200, 3), (190, 200, 205), np.uint8)
        cv2.circle(picture, (20 + 14 * frame, 120 - 8 * frame), 10, (30, 20, 200), -1, cv2.LINE_AA)
        writer.write(picture)
    writer.release()
    newcomer.types("followspot room new --video balls.avi -o room.yaml")
    newcomer.types("followspot calibrate targets --room room.yaml --pick red")
    newcomer.types("followspot calibrate targets --room room.yaml --pick red=104,72")
    newcomer.types("followspot graphs single_camera")
    newcomer.types("followspot run graphs/single_camera.yaml --room room.yaml --out own")
    rows = (newcomer.folder / "own" / "blobs.csv").read_text().splitlines()
    assert sum("red" in row for row in rows) == 12
    assert (newcomer.folder / "own" / "drawn" / "cam0.mp4").stat().st_size > 1000


def test_own_stage_on_the_page_and_a_marked_moment_that_is_verified(newcomer: Newcomer) -> None:
    extras = next((newcomer.folder.parent / "wheel").glob("*.whl"))
    newcomer.types(f"pip install --quiet '{extras}[dashboard,recording]'")
    newcomer.types("followspot new plugin studio")
    plugin = "followspot-studio"
    newcomer.types("followspot new stage still --takes Tracks --gives Tracks", plugin)
    newcomer.types("pip install --quiet -e .", plugin)
    graph = newcomer.folder / plugin / "graph.yaml"
    graph.write_text(graph.read_text() + "  still: {uses: studio.still, in: {tracks: track}}\n")
    live = ("--set", "camera.realtime=true", "--set", "camera.frames=0", "--keep", "5s")
    with newcomer.started(
        "run", "graph.yaml", *live, "--dashboard-at", "127.0.0.1:0", "--out", "out", folder=plugin
    ) as process:
        assert process.stderr is not None
        page = next(found[1] for line in process.stderr if (found := re.search(r"http://(\S+)/", line)))
        with connect(f"ws://{page}/look", proxy=None) as socket:
            scene = json.loads(socket.recv(timeout=60))
            assert "still" in {stage["name"] for stage in scene["stages"]}
        time.sleep(3)
        newcomer.types(f"followspot mark --run {process.pid} --after 1s --note first", plugin)
        process.send_signal(signal.SIGINT)
        assert "moment-" in process.communicate(timeout=120)[1]
    moment = next((newcomer.folder / plugin).rglob("moment-*.mcap"))
    count = (
        "from mcap.reader import make_reader as m; import sys;"
        " print(m(open(sys.argv[1], 'rb')).get_summary().statistics.message_count)"
    )
    assert int(newcomer.types(f'python -c "{count}" {moment}')) > 20
    assert "the same, byte for byte" in newcomer.types(f"followspot verify {moment}", plugin)

"""A run that is looked at is the same run: same tracks, same ledger, and nothing of the page stays."""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest
from browser import CHROMIUM, browser

from followspot.deploy.launch import run_plan
from followspot.graph.compile import compile_graph
from followspot.runtime.wiring import RunOptions
from followspot_page.hooks import configure, tapped
from followspot_page.showing import Address, shown

ROOT = Path(__file__).parents[2]
GRAPH = ROOT / "graphs" / "glowballs.yaml"
FRAMES = 12
PORTS = 14
"""That are looked at: of six cameras the pictures and blobs, tracks, forecast."""


@pytest.fixture(scope="module")
def unseen_tracks(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("unseen")
    assert run_plan(compile_graph(GRAPH), RunOptions(out, FRAMES)).ok
    return (out / "tracks.csv").read_bytes()


@contextmanager
def watched(out: Path, *options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A run with a page, and the page's address."""
    command = [sys.executable, "-m", "followspot.cli.main", "run", str(GRAPH), "--json", "--out", str(out)]
    command += ["--dashboard-at", "127.0.0.1:0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"http://\S+/", line)
            assert found, line
            threading.Thread(target=process.stderr.read, daemon=True).start()
            yield process, found[0]
        finally:
            process.kill()


def test_the_page_tells_what_the_run_reports(tmp_path: Path, unseen_tracks: bytes) -> None:
    parser = argparse.ArgumentParser()
    configure(parser)
    plan = tapped(compile_graph(GRAPH), parser.parse_args(["--dashboard"]))
    with shown(plan, Address("127.0.0.1", 0, firm=True)) as (url, tell):
        report = run_plan(plan, RunOptions(tmp_path, FRAMES), None, tell)
        status = json.load(urlopen(url + "status", timeout=30))
        while status["fired"] < FRAMES:  # the last word of the run is on its way
            status = json.load(urlopen(url + "status", timeout=30))
    assert report.ok
    assert (tmp_path / "tracks.csv").read_bytes() == unseen_tracks
    own = [(edge, count) for edge, count in report.edges if not edge.to_stage.startswith("page/")]
    assert len(own) == len(report.edges) - PORTS
    assert [edge["delivered"] for edge in status["edges"]] == [count.delivered for _, count in own]
    assert {stage["state"] for stage in status["stages"]} == {"over"}
    assert {path["sink"] for path in status["paths"]} == {"save"}


def test_a_run_in_many_processes_with_a_page_is_the_same_and_leaves_nothing(
    tmp_path: Path, unseen_tracks: bytes
) -> None:
    placement = ROOT / "graphs" / "placements" / "two.yaml"
    options = ("--frames", str(FRAMES), "--quiet", "--placement", str(placement))
    with watched(tmp_path, *options) as (process, url):
        out, _ = process.communicate(timeout=120)
        assert process.returncode == 0
        assert not list(Path(tempfile.gettempdir()).glob(f"followspot-page-{process.pid}-*"))
    with pytest.raises(OSError, match="refused"):
        urlopen(url, timeout=5)
    edges = json.loads(out)["edges"]
    taps = [edge for edge in edges if edge["to"].startswith("page/")]
    assert len(taps) == PORTS
    assert all(edge["kind"] == "reference" and edge["delivered"] == edge["sent"] == FRAMES for edge in taps)
    assert (tmp_path / "tracks.csv").read_bytes() == unseen_tracks


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_browser_shows_pictures_room_and_graph(tmp_path: Path) -> None:
    with watched(tmp_path / "run", "--quiet") as (process, url), browser(tmp_path / "chromium") as chromium:
        chromium.open(url, 390, 844)
        chromium.wait("document.querySelectorAll('figure:not(.dark)').length === 6")
        chromium.wait("document.querySelector('#legend li').dataset.state === 'tracked'")
        chromium.wait("document.querySelector('#life').dataset.life === 'running'")
        assert chromium.ask("document.documentElement.scrollWidth") <= 390  # nothing sticks out of a phone
        chromium.ask("document.querySelector('#groups button').focus()")
        chromium.press("Enter")
        chromium.wait("document.querySelectorAll('#detail td').length > 20")
        assert chromium.ask("document.querySelector('#detail h2').textContent") == "camera · sim.camera"
        process.send_signal(2)
        process.communicate(timeout=60)
        chromium.wait("document.querySelector('#life').dataset.life === 'ended'")
        assert [error for error in chromium.errors if "ERR_CONNECTION" not in error] == []

"""What is absent or old looks so in a browser, within a second or two, and in the metrics."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.tools.page.browser import CHROMIUM, Browser, browser
from tests.tools.page.served import GRAPH, Shown, at, served, tracks

from followspot.control.host import WorkerStatus
from followspot.control.stage_status import EdgeAge, PathStatus, StageStatus
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.messages import Message
from followspot.operator.run_status import RunStatus, SeenHost
from followspot.tracking import Frame
from followspot.worker.ledger import COLUMNS
from followspot_dashboard.picture import picture_of
from followspot_page import metrics
from followspot_watch.run_monitor import RunMonitor


def well(plan: Plan) -> RunStatus:
    """All is well: the cameras on one host, the rest here."""
    stages = [StageStatus(stage.name, "processing", fired=6) for stage in plan.stages]
    cameras = tuple(stage for stage in stages if stage.stage.startswith("camera/"))
    ages = (EdgeAge(plan.edges[0].name, 4.5, 9.0),)
    rest = tuple(replace(stage, edges=ages) for stage in stages if stage not in cameras)
    there = WorkerStatus("left", "running", 7, stages=cameras, age_s=0.1, host="pc-left")
    here = WorkerStatus(
        "main", "running", 7, stages=rest, paths=(PathStatus("camera", "save", 1, 2),), age_s=0.1
    )
    hosts = (SeenHost("pc-left", 0.1, absent=False),)
    return RunStatus((there, here), (0,) * (COLUMNS * len(plan.edges)), 7, None, hosts=hosts)


def gone(status: RunStatus) -> RunStatus:
    """The same when the other host is dead."""
    left, main = status.workers
    hosts = (SeenHost("pc-left", 12.0, absent=True),)
    return replace(status, workers=(replace(left, phase="absent", age_s=12.0), main), hosts=hosts)


def color(chromium: Browser, element: str, name: str) -> str:
    found = chromium.ask(f"getComputedStyle(document.querySelector({element!r})).{name}")
    return str(found)


def is_red(rgb: str) -> bool:
    red, green, blue = (int(number) for number in re.findall(r"\d+", rgb)[:3])
    return red > 1.5 * max(green, blue) and red > 60


def send(page: Shown, ms: int) -> None:
    """A picture of one camera, and where a target is."""
    picture = picture_of(at(ms, Frame("cam1", np.zeros((24, 32, 1), "u1"))), 320)  # type: ignore[arg-type]
    assert isinstance(picture, Message)
    page.send("camera/cam1.out", picture)
    page.send("track.tracks", at(ms, tracks(1)))


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("needs chromium")
    with browser(tmp_path_factory.mktemp("chromium")) as found:
        yield found


@pytest.fixture
def shown(tmp_path: Path, chromium: Browser) -> Iterator[tuple[Shown, Browser]]:
    """A run that goes well, and a browser that shows a picture of one of its six cameras."""
    chromium.errors.clear()
    with served(tmp_path / "run") as page:
        page.status = well(page.plan)
        chromium.open(page.url, 1280, 800)
        chromium.wait("document.querySelector('#life').dataset.life === 'running'")
        chromium.wait("document.querySelectorAll('figure').length === 6")
        send(page, 40)
        chromium.wait("document.querySelectorAll('figure:not(.dark)').length === 1")
        yield page, chromium
        chromium.open("about:blank", 1280, 800)


def test_without_faults_all_cameras_are_in_sight_and_nothing_is_marked(shown: tuple[Shown, Browser]) -> None:
    page, chromium = shown
    assert chromium.ask("document.querySelector('#faults').hidden")
    assert chromium.ask("document.querySelectorAll('figure.absent, button.bad').length") == 0
    bottoms = "[...document.querySelectorAll('figure')].map((f) => f.getBoundingClientRect().bottom)"
    area = "document.querySelector('#tiles').getBoundingClientRect().bottom"
    assert chromium.ask(f"Math.max(...{bottoms}) <= {area}")
    page.status = replace(page.status, change_awaits="host pc-left to build the new stages")
    waits = "a change waits for host pc-left to build the new stages"
    chromium.wait(f"document.querySelector('#news').innerText === {waits!r}")


def test_a_dead_host_is_seen_at_once_until_it_is_back(shown: tuple[Shown, Browser]) -> None:
    page, chromium = shown
    page.status = gone(page.status)
    chromium.wait("document.querySelectorAll('figure.absent').length === 6")
    faults = chromium.ask("document.querySelector('#faults').innerText")
    assert faults.startswith("host pc-left is absent: last heard 1")
    assert chromium.ask("document.querySelector('#life').textContent") == "fault"
    assert chromium.ask("document.title").startswith("! ")
    assert is_red(color(chromium, "#faults", "backgroundColor"))
    assert is_red(color(chromium, "#life", "color"))
    assert is_red(color(chromium, "figure.absent", "outlineColor"))
    assert is_red(color(chromium, "#pipeline button.bad", "backgroundColor"))
    bad = "[...document.querySelectorAll('#pipeline button.bad .state')].map(e => e.innerText)"
    assert [re.sub(r"\d+ s", "N s", card) for card in chromium.ask(bad)] == ["6 of 6 absent since N s"]
    chromium.wait("/these places are [0-9]+ s old/.test(document.querySelector('#legend').dataset.old)")
    chromium.ask("document.querySelector('#over').click()")
    chromium.wait("/host pc-left is absent/.test(document.querySelector('.log .fault')?.innerText)")
    assert chromium.ask("document.querySelectorAll('.plot line.fault').length") == 4, "one in each plot"

    page.status = well(page.plan)
    chromium.wait("/over: host pc-left is absent/.test(document.querySelector('.log').innerText)")
    chromium.wait("document.querySelectorAll('figure.absent').length === 0")
    chromium.wait("document.querySelector('#life').dataset.life === 'running'")
    send(page, 80)
    chromium.wait("document.querySelectorAll('figure.old').length === 0")
    assert chromium.errors == []


def test_a_run_that_hangs_or_is_killed_is_seen_at_once(shown: tuple[Shown, Browser]) -> None:
    page, chromium = shown
    os.kill(page.pid, signal.SIGSTOP)
    chromium.wait("document.querySelector('#life').dataset.life === 'fault'")
    faults = chromium.ask("document.querySelector('#faults').innerText")
    assert re.match(r"this page has heard nothing of the run for \d+ s", faults)
    assert chromium.ask("document.body.classList.contains('old')")
    chromium.wait("document.querySelectorAll('figure.old').length === 1")
    os.kill(page.pid, signal.SIGCONT)
    chromium.wait("document.querySelector('#life').dataset.life === 'running'")
    assert chromium.errors == []
    os.kill(page.pid, signal.SIGKILL)
    chromium.wait("document.querySelector('#life').dataset.life === 'gone'")
    faults = chromium.ask("document.querySelector('#faults').innerText")
    assert faults.startswith("this page has lost its run")


def samples(run: RunMonitor, targets: metrics.Targets) -> dict[str, float]:
    found = re.findall(
        r"^followspot_([a-z_]+(?:\{.*\})?) (\S+)$", metrics.text(run, targets, 0), re.MULTILINE
    )
    return {name: float(value) for name, value in found}


def test_the_metrics_tell_what_is_absent_and_how_old_everything_is(tmp_path: Path) -> None:
    plan, now = compile_graph(GRAPH), [0.0]
    run, targets = RunMonitor(plan, lambda: now[0]), metrics.Targets(plan.room, lambda: now[0])
    assert "target_age_seconds" not in samples(run, targets)
    run.take(well(plan))
    targets.take("track.tracks", at(40, tracks(1)))
    before = samples(run, targets)
    assert (before["faults"], before["status_age_seconds"], before["target_age_seconds"]) == (0, 0, 0)
    assert before['host_absent{host="pc-left"}'] == 0
    assert before['worker_running{worker="left"}'] == before['worker_running{worker="main"}'] == 1
    assert before['target_state{target="green",state="tracked"}'] == 1
    assert any(name.startswith("edge_age_seconds") for name in before)
    assert any(name.startswith("path_latency_seconds") for name in before)

    run.take(gone(well(plan)))
    dead = samples(run, targets)
    assert (dead["faults"], dead['host_absent{host="pc-left"}']) == (1, 1)
    assert dead['host_age_seconds{host="pc-left"}'] == dead['worker_age_seconds{worker="left"}'] == 12
    assert (dead['worker_running{worker="left"}'], dead['worker_running{worker="main"}']) == (0, 1)
    assert dead['stage_fired_total{stage="camera/cam0"}'] == 6  # the last that is known

    now[0] += 3.0  # and now the run itself does not answer
    silent = samples(run, targets)
    assert (silent["faults"], silent["status_age_seconds"], silent["target_age_seconds"]) == (2, 3, 3)
    assert silent['worker_running{worker="main"}'] == 0
    assert silent['target_state{target="green",state="old"}'] == 1
    assert silent['target_state{target="green",state="tracked"}'] == 0
    assert not any(name.startswith(("edge_age_seconds", "path_latency_seconds")) for name in silent)


def test_a_target_that_one_of_two_trackers_has_is_not_lost(tmp_path: Path) -> None:
    plan, now = compile_graph(GRAPH), [0.0]
    targets = metrics.Targets(plan.room, lambda: now[0])
    assert targets.state == {}
    targets.take("hall/track.tracks", at(40, tracks(1, 3)))
    targets.take("stage/track.tracks", at(40, tracks(2)))
    assert dict(targets.state) == {"green": "tracked", "red": "predicted", "blue": "lost"}
    now[0] += 1.5
    targets.take("stage/track.tracks", at(80, tracks(2)))
    now[0] += 1.0  # the other one has been silent for too long
    assert dict(targets.state) == {"green": "missing", "red": "lost", "blue": "lost"}
    assert targets.age_s == 1.0
    now[0] += 1.5
    assert set(targets.state.values()) == {"old"}

"""Sensors, depth cameras, orientations, uncertainty and several trackers as a browser shows them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cv2
import numpy as np
import pytest
from tests.stages.sensors import Pressure, posed, resting
from tests.tools.page.browser import CHROMIUM, Browser, browser
from tests.tools.page.sensor_room import worn
from tests.tools.page.served import Shown, at, served, tracks

from followspot.control.host import WorkerStatus
from followspot.control.stage_status import StageStatus
from followspot.messages import Array
from followspot.operator.run_status import RunStatus
from followspot.tracking import DepthImage
from followspot.worker.ledger import COLUMNS
from followspot_dashboard.picture import picture_of

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
SENSORS = "[...document.querySelectorAll('figure.sensor')]"
BLUE = """(() => {
    const canvas = document.querySelector("figure.sensor canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height / 2);
    const columns = new Set();
    for (let i = 0; i < data.length; i += 4) {
        const blue = data[i + 3] > 60 && data[i + 2] > 200 && data[i] < 150;
        if (blue && i / 4 / canvas.width > 18) columns.add((i / 4) % canvas.width);
    }
    return columns.size / canvas.width;
})()"""
"""The share of the columns of the upper plot, below its title, that have the colour of z."""
RUNNING = "document.querySelector('#life')?.dataset.life === 'running'"
AXES = ("#ff7a6b", "#6fe39a", "#74a8ff")
Opened = tuple[Shown, Browser]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """The page of a graph with sensors and depth cameras."""
    folder = tmp_path_factory.mktemp("worn")
    plan = worn(folder)
    with served(folder, plan) as page, browser(folder / "chromium") as chromium:
        stages = tuple(StageStatus(stage.name, "getting", fired=7) for stage in plan.stages)
        worker = WorkerStatus("main", "running", 7, stages=stages, age_s=0.1)
        page.status = RunStatus((worker,), (0,) * (COLUMNS * len(plan.edges)), 7, None)
        chromium.open(page.url, 1024, 768)
        chromium.wait(RUNNING)
        yield page, chromium


def seen(chromium: Browser, colors: tuple[str, ...], element: str) -> list[int]:
    """Pixels of each colour within an element."""
    box = chromium.ask(f"document.querySelector({element!r}).getBoundingClientRect().toJSON()")
    left, top, right, bottom = (round(box[side]) for side in ("left", "top", "right", "bottom"))
    shot = cv2.imdecode(np.frombuffer(chromium.picture(), "u1"), cv2.IMREAD_COLOR)
    assert shot is not None
    part = shot[top:bottom, left:right].astype(int)
    wanted = [[int(color[i : i + 2], 16) for i in (5, 3, 1)] for color in colors]
    return [int((np.abs(part - bgr).max(axis=2) < 12).sum()) for bgr in wanted]


def until(condition: Callable[[], bool]) -> None:
    """Asks at most thirty times."""
    assert any(condition() for _ in range(30))


def pose(quaternion: list[float]) -> Array:
    return np.array([quaternion])


def test_each_sensor_of_the_room_has_a_tile_and_says_where_nothing_came(opened: Opened) -> None:
    _, chromium = opened
    names = f"{SENSORS}.map((figure) => figure.querySelector('figcaption').firstChild.data)"
    assert chromium.ask(names) == ["wrist", "air", "spare"]
    said = f"getComputedStyle({SENSORS}[2].querySelector('figcaption'), '::after').content"
    assert chromium.ask(said) == '"no readings"'


def test_readings_are_lines_and_those_of_an_unknown_type_a_table(opened: Opened) -> None:
    page, chromium = opened
    page.send("imu/wrist.out", at(4000, resting(4_000_000_000, step=400_000_000)))
    page.send("air/air.out", at(100, Pressure("well", np.array([1.25, 2.5]))))
    chromium.wait(f"{SENSORS}.filter((figure) => figure.classList.contains('dark')).length === 1")
    page.send("air/air.out", at(300, Pressure("well", np.array([1.25, 2.5]))))
    chromium.wait(f"{SENSORS}[0].innerText.includes('2.5/s of 100/s · on target red')")
    chromium.wait(f"{SENSORS}[1].innerText.includes('barometer · 1000/s')")  # 200 messages more in 200 ms
    assert chromium.ask(
        f"[...{SENSORS}[1].querySelectorAll('tr')].map((row) => row.innerText.split('\\t'))"
    ) == [
        ["status", "height, m"],
        ["well", "1.25"],
        ["well", "2.5"],
    ]
    chromium.wait(f"{BLUE} > 0")
    assert 0.6 < chromium.ask(BLUE) < 0.8  # z is drawn last, through 3.6 of the last 5 s


def test_depth_has_a_picture_with_its_scale(opened: Opened) -> None:
    page, chromium = opened
    depth = np.full((240, 320), 4.0, "f4")
    depth[:, :160] = 0
    picture = picture_of(at(40, DepthImage("depth0", depth)), 320)  # type: ignore[arg-type]
    assert picture is not None
    page.send("camera/depth0.out", picture)
    chromium.wait("document.querySelectorAll('figure:not(.dark):not(.sensor)').length === 1")
    assert chromium.ask("document.querySelector('figure .scale').innerText").split() == ["0", "8", "m"]
    canvas = "document.querySelector('figure canvas')"
    pixel = f"{canvas}.getContext('2d').getImageData({{}}, 120, 1, 1).data.slice(0, 3)"
    half = chromium.ask(f"{canvas}.width / 2")
    chromium.wait(f"{pixel.format(half + 30)}[1] > 150")
    black, green = ([*chromium.ask(pixel.format(x)).values()] for x in (half - 30, half + 30))
    assert max(black) < 12
    assert green[1] == max(green)


def test_a_target_with_an_orientation_shows_its_axes_and_one_without_none(opened: Opened) -> None:
    page, chromium = opened
    upright = [1.0, 0.0, 0.0, 0.0]
    chromium.open(page.url, 2048, 1536)  # more pixels for the room
    chromium.wait(RUNNING)
    chromium.ask("document.querySelector('#pipeline').hidden = true")
    chromium.ask("document.querySelector('#view').style.filter = 'none'")  # old or not, here colours count

    def axes(ms: int, quaternion: list[float]) -> list[int]:
        page.send("pose.out", at(ms, posed(tracks(1), pose(quaternion))))
        return seen(chromium, AXES, "#stage")

    until(lambda: min(axes(50, upright)) > 10)
    until(lambda: max(axes(60, [np.nan] * 4)) < 5)
    assert chromium.errors == []

"""The page of a calibration: one file, whole, escaped, readable without scripts."""

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room

from followspot_calibrate.report import (
    Course,
    Page,
    calibration_page,
    drift_charts,
    hue_bars,
    pair_table,
    plain_table,
    write_report,
)
from followspot_calibrate.report.elements import html
from followspot_calibrate.report.pictures import cell_counts
from followspot_calibrate.report.scene import axes, floor_grid
from followspot_calibrate.triangulation import triangulate

VOID = {"meta", "br"}


class Outline(HTMLParser):
    """Tags must close in order; headings, attributes and text are kept."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[str] = []
        self.links: list[str] = []
        self.paths: list[dict[str, str | None]] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href")]
        if tag == "path":
            self.paths.append(dict(attrs))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def page() -> Page:
    room = made_room(3, 200, outliers=0.05, noise=0.3)
    found = triangulate(room.cameras, room.sightings.pixel)
    residual = np.where(found.used[..., None], found.residual, np.nan)
    return calibration_page(
        "Wand <script>alert(1)</script> & more",
        "look",
        "cam1 is odd",
        room.cameras,
        room.sightings.pixel,
        found.points,
        residual,
        planes={"floor": np.array([0.0, 0.0, 1.0, 0.0])},
        warnings=["5 < 6 & that's all"],
        marked=["cam1"],
    )


def written(path: Path, shown: Page) -> str:
    write_report(path / "page.html", shown)
    return (path / "page.html").read_text(encoding="utf-8")


def test_a_page_is_whole_and_has_a_section_per_camera(tmp_path: Path) -> None:
    outline = Outline(written(tmp_path, page()))
    assert outline.headings == ["Cameras", "Cameras in the room", "cam0", "cam1", "cam2"]


def test_names_and_warnings_are_escaped(tmp_path: Path) -> None:
    text = written(tmp_path, page())
    assert "<script>alert" not in text
    assert "Wand &lt;script&gt;alert(1)&lt;/script&gt; &amp; more" in text
    assert "5 &lt; 6 &amp; that's all" in text


def test_a_page_loads_nothing_from_elsewhere(tmp_path: Path) -> None:
    text = written(tmp_path, page())
    assert Outline(text).links == []
    assert "http" not in text
    assert "url(" not in text
    assert "@import" not in text


def test_the_scene_is_drawn_without_scripts_and_carries_its_points_for_them(tmp_path: Path) -> None:
    scene = [path for path in Outline(written(tmp_path, page())).paths if "data-p" in path]
    assert len(scene) > 6
    for path in scene:
        points = (path["data-p"] or "").replace(";", " ").split()
        drawn = (path["d"] or "").replace("h0", "").replace("M", " ").replace("L", " ").split()
        assert len(points) == len(drawn) > 0
        assert "nan" not in (path["d"] or "")


@pytest.mark.parametrize(("radius", "length"), [(4.0, 1.0), (300.0, 30.0)])
def test_axes_are_a_metre_long_or_as_long_as_can_be_seen(radius: float, length: float) -> None:
    ends = [line[1] for (line,), _ in axes(radius)]
    np.testing.assert_allclose(ends, length * np.eye(3))


@pytest.mark.parametrize(("radius", "step"), [(4.0, 1.0), (250.0, 10.0)])
def test_the_grid_of_the_floor_covers_the_scene_in_equal_squares(radius: float, step: float) -> None:
    center = np.array([3.3, -2.2, 1.0])
    lines = np.array(floor_grid(center, radius))
    assert (lines[..., 2] == 0).all()
    for axis in (0, 1):
        at = np.unique(lines[lines[:, 0, axis] == lines[:, 1, axis], 0, axis])
        np.testing.assert_allclose(np.diff(at), step)
        assert at[0] <= center[axis] - radius
        assert at[-1] >= center[axis] + radius


def test_hues_stand_beside_each_other_in_their_own_colours() -> None:
    text = html(hue_bars("Hues", {"cam0": np.arange(16.0)}, "").content[0])
    bars = re.findall(
        r'<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)" fill="hsl\((\d+)', text
    )
    x, y, width, height, hue = np.array(bars, float).T
    assert (x[1:] > x[:-1] + width[:-1]).all()
    np.testing.assert_allclose(y + height, y[0] + height[0], atol=0.1)
    np.testing.assert_allclose(height, height[-1] * np.arange(16) / 15, atol=0.1)
    assert hue.tolist() == [int(360 * (n + 0.5) / 16 + 0.5) for n in range(16)]


def test_what_was_left_out_is_crossed(tmp_path: Path) -> None:
    number = r"(-?[\d.]+)"
    cross = rf"M{number},{number}l{number},{number}m0,{number}l{number},{number}"
    drawn = [
        [float(value) for value in found]
        for path in Outline(written(tmp_path, page())).paths
        for found in re.findall(cross, path["d"] or "")
    ]
    assert len(drawn) > 5
    for _, _, right, down, back_up, left, down_again in drawn:
        assert right == down == down_again == -back_up == -left > 0


def test_residuals_that_are_lengths_only_are_drawn_too(tmp_path: Path) -> None:
    room = made_room(2, 30)
    found = triangulate(room.cameras, room.sightings.pixel)
    length = np.linalg.norm(found.residual, axis=2)
    shown = calibration_page("t", "good", "s", room.cameras, room.sightings.pixel, found.points, length)
    assert "radii of discs" in written(tmp_path, shown)


def test_a_camera_that_saw_nothing_has_a_section_that_says_so(tmp_path: Path) -> None:
    room = made_room(3, 30)
    pixel = room.sightings.pixel.copy()
    pixel[:, 2] = np.nan
    found = triangulate(room.cameras, pixel)
    text = written(
        tmp_path, calibration_page("t", "good", "s", room.cameras, pixel, found.points, found.residual)
    )
    assert Outline(text).headings[-1] == "cam2"
    assert "saw no points" in text


def test_pairs_drift_and_tables_are_whole_even_without_values(tmp_path: Path) -> None:
    nothing = np.full((2, 2), np.nan)
    sections = [
        pair_table("Pairs", ["a", "b"], nothing, np.zeros((2, 2)), limit=1.0, note=""),
        drift_charts([Course("a", np.arange(3.0), np.full((3, 2), np.nan), np.full(3, np.nan))], 1.0),
        drift_charts([Course("b", np.arange(3.0), np.ones((3, 2)), np.ones(3), moved=1.0)], 1.0),
        drift_charts([Course("c", np.empty(0), np.empty((0, 2)), np.empty(0))], 1.0),
        plain_table("Empty", ["x"], []),
    ]
    text = written(tmp_path, Page("t", "bad", "s", (), sections))
    assert Outline(text).headings == ["Pairs", "Drift", "Drift", "Drift", "Empty"]
    assert "moved at 1.0 s" in text


def test_coverage_counts_points_per_part_of_the_picture() -> None:
    counts = cell_counts((320, 240), np.array([[0, 0], [1, 1], [319.9, 239.9], [320.4, 240.0], [160, 0]]))
    assert counts[0, 0] == 2
    assert counts[-1, -1] == 2
    assert counts[0, 4] == 1
    assert counts.sum() == 5

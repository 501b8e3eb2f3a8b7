"""The layout of the demo that is shipped for Foxglove shows topics that a recording of the demo has."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.commands import command

pytest.importorskip("mcap")
ROOT = Path(__file__).parents[3]
LAYOUT = ROOT / "graphs/views/glowballs.foxglove.json"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The topics of a recording of the demo, and the schema of each."""
    from mcap.reader import make_reader

    folder = tmp_path_factory.mktemp("demo")
    words = ("--frames", 3, "--record", folder / "demo.mcap", "--out", folder / "out", "--quiet")
    command("run", ROOT / "graphs/glowballs.yaml", *words, check=True)
    with (folder / "demo.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}


def panels(part: Any) -> Iterator[str]:
    """The names of the panels that a layout arranges."""
    if isinstance(part, str):
        yield part
        return
    assert part["direction"] in ("row", "column")
    assert 0 < part["splitPercentage"] < 100
    yield from panels(part["first"])
    yield from panels(part["second"])


def test_the_layout_of_the_demo_shows_what_is_recorded(recorded: dict[str, str]) -> None:
    layout = json.loads(LAYOUT.read_text())
    config = layout["configById"]
    arranged = list(panels(layout["layout"]))
    assert sorted(arranged) == sorted(config), "each panel once"
    images = [panel["imageMode"] for name, panel in config.items() if name.startswith("Image!")]
    assert {image["imageTopic"] for image in images} == {
        topic for topic, schema in recorded.items() if schema == "foxglove.CompressedImage"
    }
    assert {recorded[image["calibrationTopic"]] for image in images} == {"foxglove.CameraCalibration"}
    laid = [topic for image in images for topic in image["annotations"]]
    assert sorted(laid) == sorted(t for t, s in recorded.items() if s == "foxglove.ImageAnnotations")
    assert recorded[config["RosOut!log"]["topicToRender"]] == "foxglove.Log"
    shown = {recorded[topic] for topic in config["3D!room"]["topics"]}
    assert shown == {
        "foxglove.SceneUpdate",
        "foxglove.PointCloud",
        "foxglove.FrameTransform",
        "foxglove.CameraCalibration",
    }

"""What an editor is told is what followspot accepts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from followspot.cli.main import main
from followspot.graph.declaration import ENVELOPE
from followspot.graph.override import SUBGRAPH
from followspot.plugins.catalogue import catalogue
from followspot_schema.documents import document

ROOT = Path(__file__).parent.parent.parent
GRAPHS = sorted((ROOT / "graphs").glob("*.yaml"))
ROOMS = sorted((ROOT / "graphs" / "rooms").glob("*.yaml"))
PLACEMENTS = sorted((ROOT / "graphs" / "placements").glob("*.yaml"))


@pytest.fixture(scope="module")
def schemas() -> dict[str, dict[str, Any]]:
    return {kind: document(kind) for kind in ("graph", "room", "placement")}


def valid(data: Any, schema: dict[str, Any]) -> None:
    """Raises jsonschema.ValidationError. That it is a schema is tested once."""
    jsonschema.Draft202012Validator(schema).validate(data)


@pytest.mark.parametrize("kind", ["graph", "room", "placement"])
def test_it_is_a_schema(schemas: dict[str, dict[str, Any]], kind: str) -> None:
    jsonschema.Draft202012Validator.check_schema(schemas[kind])


@pytest.mark.parametrize(
    ("kind", "file"),
    [("graph", f) for f in GRAPHS] + [("room", f) for f in ROOMS] + [("placement", f) for f in PLACEMENTS],
    ids=lambda value: getattr(value, "stem", value),
)
def test_every_ready_file_is_accepted(schemas: dict[str, dict[str, Any]], kind: str, file: Path) -> None:
    valid(yaml.safe_load(file.read_text()), schemas[kind])


@pytest.mark.parametrize(
    "text",
    [
        "stages: {fuse: {uses: balls.mean_shfit, in: {candidates: x}}}",
        "stages: {fuse: {uses: balls.mean_shift}}",
        "stages: {fuse: {uses: balls.mean_shift, in: {candidate: x}}}",
        "stages: {color: {uses: balls.color_blobs, in: {frame: x}, with: {similarity: much}}}",
        "stages: {color: {uses: balls.color_blobs, in: {frame: x}, with: {similarty: 0.5}}}",
        "stages: {color: {uses: balls.color_blobs, in: {frame: x}, each: a b}}",
        "stages: {video: {uses: cameras.video}}",
        "stages: {fuse: {uses: balls.mean, in: {candidates: {from: x, dely: 1}}}}",
        "graph: empty",
        "stages: {hall: {graph: a.yaml, wiht: {similarity: 0.5}}}",
        "stages: {hall: {graph: a.yaml, uses: balls.mean}}",
        "{extends: a.yaml, stages: {fuse: {use: balls.mean}}}",
        "{outputs: {tracks: 7}, stages: {}}",
        "stages: {fuse: null}",
    ],
)
def test_a_mistake_in_a_graph_is_seen(schemas: dict[str, dict[str, Any]], text: str) -> None:
    with pytest.raises(jsonschema.ValidationError):
        valid(yaml.safe_load(text), schemas["graph"])


@pytest.mark.parametrize(
    "source",
    [
        {"uses": "cameras.vidoe", "with": {"path": "a.mkv"}},
        {"uses": "cameras.video", "with": {"pth": "a.mkv"}},
        {"uses": "cameras.video"},
        {"uses": "balls.kalman"},
        {"uses": "sim.truth"},
    ],
)
def test_a_mistake_in_the_source_of_a_camera_is_seen(
    schemas: dict[str, dict[str, Any]], source: dict[str, Any]
) -> None:
    room = yaml.safe_load((ROOT / "graphs" / "rooms" / "simulated.yaml").read_text())
    room["cameras"]["cam0"]["source"] = {"uses": "cameras.video", "with": {"path": "a.mkv"}}
    valid(room, schemas["room"])
    room["cameras"]["cam0"]["source"] = source
    with pytest.raises(jsonschema.ValidationError):
        valid(room, schemas["room"])


@pytest.mark.parametrize(
    "text",
    [
        "{extends: a.yaml, stages: {fuse: {uses: balls.mean}, bridge: null, track: {with: {x: 1}}}}",
        "stages: {hall: {graph: a.yaml, cameras: cameras, with: {x: 1}, in: {frames: b}}}",
        "{params: {x: a/b.x}, inputs: {y: [a/b, c.y]}, stages: {a/b: {uses: sim.camera}}}",
        "{outputs: {z: a/b.out}, stages: {a/b: {uses: sim.camera}}}",
    ],
)
def test_overlays_sub_graphs_and_interfaces_are_accepted(
    schemas: dict[str, dict[str, Any]], text: str
) -> None:
    valid(yaml.safe_load(text), schemas["graph"])


def test_the_schema_knows_every_key_and_every_stage(schemas: dict[str, dict[str, Any]]) -> None:
    stage = schemas["graph"]["$defs"]["stage"]
    assert set(stage["properties"]) == set(ENVELOPE)
    assert set(schemas["graph"]["$defs"]["subgraph"]["properties"]) == set(SUBGRAPH)
    assert set(stage["properties"]["uses"]["anyOf"][0]["enum"]) >= set(catalogue())


def test_the_command_writes_a_file(tmp_path: Path) -> None:
    out = tmp_path / "graph.schema.json"
    assert main(["schema", "graph", "-o", str(out)]) == 0
    assert json.loads(out.read_text())["title"] == "followspot graph"

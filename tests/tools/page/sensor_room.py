"""A graph of depth cameras, sensors and posed tracks, for tests of the page."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan

ROOT = Path(__file__).parents[3]
_ROOM = ROOT / "graphs" / "rooms" / "simulated_depth.yaml"
_SENSORS = """\
sensors:
  wrist: {kind: imu, rate: 100, mount: {target: red}, source: {uses: sensors.imu}}
  air: {kind: barometer, source: {uses: sensors.barometer}}
  spare: {kind: imu}
"""
_GRAPH = f"""\
graph: worn
extends: {ROOT}/graphs/depth.yaml
room: room.yaml
stages:
  imu:  {{uses: room.source, each: "sensors[name=wrist]"}}
  air:  {{uses: room.source, each: "sensors[kind=barometer]"}}
  pose: {{uses: sensors.pose, in: {{tracks: track, turning: imu, air: air}}}}
"""


def worn(folder: Path) -> Plan:
    """Its plan; the files are written to a folder."""
    (folder / "room.yaml").write_text(_ROOM.read_text(encoding="utf-8") + _SENSORS, encoding="utf-8")
    (folder / "worn.yaml").write_text(_GRAPH, encoding="utf-8")
    return compile_graph(folder / "worn.yaml", plugin_files=[ROOT / "tests" / "stages" / "sensors.py"])

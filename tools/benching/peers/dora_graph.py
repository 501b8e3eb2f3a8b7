"""The tracker as a dora graph: a node for each camera, and one for the fusion."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from benching.peers.parts import Order, read_order


def run(order: Order) -> None:
    """Write the graph, and run it with the command of dora."""
    cameras = list(order.plan().room.cameras)
    file = str(order.written())
    nodes = [node("fusion", {camera: f"{camera}/blobs" for camera in cameras}, "forecast", file)]
    nodes += [node(camera, {"forecast": "fusion/forecast"}, "blobs", file, camera) for camera in cameras]
    graph = order.path("dataflow.yml")
    graph.write_text(json.dumps({"nodes": nodes}), encoding="utf-8")
    subprocess.run([Path(sys.executable).with_name("dora"), "run", graph], check=True, cwd=order.folder)


def node(name: str, inputs: dict[str, str], output: str, *words: str) -> dict[str, object]:
    """One node as the file of a graph has it."""
    command = " ".join(("-m", "benching.peers.dora_node", *words))
    return {"id": name, "path": sys.executable, "args": command, "inputs": inputs, "outputs": [output]}


if __name__ == "__main__":
    run(read_order(sys.argv[1]))

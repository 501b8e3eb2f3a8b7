"""The graphs and the decoder of docs/pose_nets.md work with files of the names that the page gives."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.persons.drawn import frame_of, perspective, ready
from tests.plugins.persons.pose_net.tiny_models import TINY_BLAZEPOSE, lit

import followspot as fs
from followspot.plugins.registry import load_stage, use_plugin_files

ROOT = Path(__file__).parents[4]
PAGE = (ROOT / "docs/pose_nets.md").read_text(encoding="utf-8")
GRAPHS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", GRAPHS, ids=lambda text: text.split()[1])
def test_a_graph_of_the_page_has_no_mistake(text: str, tmp_path: Path) -> None:
    if ".onnx" in text:
        pytest.importorskip("onnxruntime")
    (tmp_path / "movenet_multipose.onnx").write_bytes(lit(np.zeros((6, 56))))
    (tmp_path / "pose_landmark_full.tflite").write_bytes(TINY_BLAZEPOSE)
    graph = tmp_path / "graph.yaml"
    graph.write_text(re.sub(r"graphs/", f"{ROOT}/graphs/", text))
    assert fs.check(graph) == []


def test_the_decoder_of_the_page_finds_what_its_model_says(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    (code,) = re.findall(r"```python\n# mine.py\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "mine.py").write_text(code)
    model = tmp_path / "heads.onnx"
    model.write_bytes(lit(np.array([[0.5, 0.25, 0.9], [0.1, 0.1, 0.2]]), kind="float"))
    use_plugin_files([str(tmp_path / "mine.py")])
    net = ready(load_stage("mine.my_pose_net"), perspective(), model=model, decoder="heads")
    found = net.process(frame_of(perspective(), np.full((240, 320, 3), 255, np.uint8)))
    assert found.points.labels == ("nose",)
    assert found.points.pixel.tolist() == [pytest.approx([0.5 * 352 * 320 / 341 - 0.5, 0.25 * 240 - 0.5])]
    assert len(found.boxes.box) == 0

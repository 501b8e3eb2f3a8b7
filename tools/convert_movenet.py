"""Convert MoveNet MultiPose from a TensorFlow.js graph model to ONNX, once, for `persons.pose_net`.

    python tools/convert_movenet.py models/movenet-multipose.json movenet_multipose.onnx

It needs an environment of its own with `tensorflow-cpu==2.15.1 tf2onnx==1.16.1 'numpy<2'`; docs/pose_nets.md
says where the model comes from. Convolutions that TensorFlow.js fused with a bias and an activation are split
again, since the converter knows them only apart.
"""

from __future__ import annotations

import argparse
import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

FUSED = {"_FusedConv2D": "Conv2D", "FusedDepthwiseConv2dNative": "DepthwiseConv2dNative"}
"""Operators of TensorFlow.js with a bias and an activation, and what they are without."""
KEPT = ("T", "strides", "padding", "data_format", "dilations", "explicit_paddings")
"""Attributes of a fused operator that the plain one has, too."""
OPSET = 13


def main() -> None:
    """Convert the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=Path, help="the .json file; its .bin file lies beside it")
    parser.add_argument("onnx", type=Path, help="the file to write")
    given = parser.parse_args()
    document = json.loads(given.model.read_text("utf-8"))
    weights = weights_of(document["weightsManifest"], given.model.parent)
    convert(graph_of(document["modelTopology"], weights), given.onnx)


def weights_of(manifest: list[dict[str, Any]], folder: Path) -> dict[str, np.ndarray[Any, Any]]:
    """The weights by name; half precision becomes single."""
    found = {}
    for group in manifest:
        data, at = b"".join((folder / path).read_bytes() for path in group["paths"]), 0
        for weight in group["weights"]:
            stored = np.dtype(weight.get("quantization", weight)["dtype"])
            count = int(np.prod(weight["shape"], dtype=int))
            values = np.frombuffer(data, stored, count, at).reshape(weight["shape"])
            found[weight["name"]] = values.astype(weight["dtype"])
            at += values.nbytes
    return found


def unfused(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A node, or the convolution, the bias and the activation that it stands for."""
    if node["op"] not in FUSED:
        yield node
        return
    picture, kernel, *bias = node["input"]
    words = node["attr"]["fused_ops"]["list"].get("s", [])
    steps = [base64.b64decode(word).decode() for word in words]
    names = [*(f"{node['name']}/{i}" for i in range(len(steps))), node["name"]]
    kept = {key: node["attr"][key] for key in KEPT if key in node["attr"]}
    yield {"name": names[0], "op": FUSED[node["op"]], "input": [picture, kernel], "attr": kept}
    for step, before, name in zip(steps, names, names[1:], strict=False):
        inputs = [before, *bias] if step == "BiasAdd" else [before]
        yield {"name": name, "op": step, "input": inputs, "attr": {"T": {"type": "DT_FLOAT"}}}


def graph_of(topology: dict[str, Any], weights: dict[str, np.ndarray[Any, Any]]) -> Any:
    """TensorFlow's GraphDef with its weights."""
    import tensorflow as tf
    from google.protobuf.json_format import ParseDict

    nodes = [plain for node in topology["node"] for plain in unfused(node)]
    graph = ParseDict({"node": nodes, "versions": topology["versions"]}, tf.compat.v1.GraphDef())
    for node in graph.node:
        if node.op == "Const":
            node.attr["value"].tensor.CopyFrom(tf.make_tensor_proto(weights[node.name]))
            node.attr["dtype"].type = tf.as_dtype(weights[node.name].dtype).as_datatype_enum
    return graph


def convert(graph: Any, onnx: Path) -> None:
    """Write a GraphDef as ONNX, from its input `input` to its output `Identity`."""
    import tf2onnx

    names = {"input_names": ["input:0"], "output_names": ["Identity:0"]}
    tf2onnx.convert.from_graph_def(graph, opset=OPSET, output_path=str(onnx), **names)


if __name__ == "__main__":
    main()

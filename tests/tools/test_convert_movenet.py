"""Reading a TensorFlow.js model: weights in half precision, and fused convolutions split again."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

import numpy as np
import pytest

from convert_movenet import unfused, weights_of


def test_weights_of_several_files_are_read_in_their_order_and_precision(tmp_path: Path) -> None:
    half, whole = np.array([[1.5, -2]], np.float16), np.array([7, 8, 9], np.int32)
    data = half.tobytes() + whole.tobytes()
    (tmp_path / "a.bin").write_bytes(data[:6])
    (tmp_path / "b.bin").write_bytes(data[6:])
    weights = [
        {"name": "half", "shape": [1, 2], "dtype": "float32", "quantization": {"dtype": "float16"}},
        {"name": "whole", "shape": [3], "dtype": "int32"},
    ]
    found = weights_of([{"paths": ["a.bin", "b.bin"], "weights": weights}], tmp_path)
    assert found["half"].dtype == np.float32
    assert np.array_equal(found["half"], half)
    assert found["whole"].dtype == np.int32
    assert np.array_equal(found["whole"], whole)


@pytest.mark.parametrize(
    ("fused", "plain"), [("_FusedConv2D", "Conv2D"), ("FusedDepthwiseConv2dNative", "DepthwiseConv2dNative")]
)
def test_a_fused_convolution_becomes_three_nodes_of_which_the_last_has_its_name(
    fused: str, plain: str
) -> None:
    steps = [b64encode(word).decode() for word in (b"BiasAdd", b"Relu6")]
    attr = {"fused_ops": {"list": {"s": steps}}, "strides": {"list": {"i": ["2"]}}, "epsilon": {"f": 0}}
    node = {"name": "conv", "op": fused, "input": ["x", "kernel", "bias"], "attr": attr}
    first, bias, last = unfused(node)
    assert (first["op"], first["input"]) == (plain, ["x", "kernel"])
    assert first["attr"] == {"strides": attr["strides"]}
    assert (bias["op"], bias["input"]) == ("BiasAdd", [first["name"], "bias"])
    assert (last["op"], last["input"], last["name"]) == ("Relu6", [bias["name"]], "conv")


def test_other_nodes_stay_and_a_convolution_without_steps_keeps_its_name() -> None:
    node = {"name": "sum", "op": "AddV2", "input": ["a", "b"], "attr": {}}
    assert list(unfused(node)) == [node]
    bare = {"name": "conv", "op": "_FusedConv2D", "input": ["x", "k"], "attr": {"fused_ops": {"list": {}}}}
    (only,) = unfused(bare)
    assert (only["name"], only["op"], only["input"]) == ("conv", "Conv2D", ["x", "k"])

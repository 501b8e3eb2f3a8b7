"""Models of a few operators, whose outputs are known: ONNX written as bytes, and one of TensorFlow Lite."""

from __future__ import annotations

import zlib
from base64 import b85decode
from collections.abc import Iterable, Sequence

import numpy as np

from followspot.messages import Array
from followspot_persons.pose_net.movenet import MoveNetMultiPose

FLOAT, INT = 1, 6
_TFLITE = (
    b"c-rk)L2DC16n@EWHnCmPh(Uvtl0y$YNXW((JctsKih;D18ay@#4K`pBsIe%Bc+4RO@#IN7iB$01gLvtsr{d9r_!~TkC+Yaj%"
    b"-hXos{R0(7ryMwoA-ThW->$aGEYRUo6ReED$+a^C{H=^;meSVHo>Pc1m2w`Islf>5jmtS2`mFH@Kp#g!|n4xZDalJ>gJus#("
    b"H~gwN<TGTUF@#N;`w`GqKoSx8L4<)E{<xo%UX5_hEO?r&;*R$hQRe5dMt*N8k<c3U~pGfF0IZ_$h>ZwgA0`Y?LbpEUFoM%I7"
    b"gh+l*SZ^vn4>ye?No6IDvVN+}?E#`;n#D6N#rG%@$P5E;M+-g2Cr!~6aH>mfd|Kg@f~{YAME^t?t>X7-iu#svS0wOq@!T+6j"
    b"w%e7p~{a?7#zukO?tXZ?hHu@#R7??wQt=ZTt)&_mlQp3)6i4ySTRa7>r^5k90vR~GCWdvOXt|j#S>fP)1iR+;wuCq*y*_Z|_"
    b"A$5wf0enC`nBca2$Y+}MQhbLU*1Kfr6`8Yyx66@+tkdSAI?dGfV%o`QEK3(u&2~yVRp#1Nujk^_o<!o4Bq~R0l2hgIcuk>C)"
    b"|y|?83RoqpU`#d7`Vl2-Z~LNQgU2NN=`wJpXmCzvE4x-Jbcm)bi6s0*9Je${1N<_7@z1g{}A|Q@IB@q!7oeE>fZg^gTaGJ{S"
    b"SP(zYAiTpJIMSXudplm3lh}{=(lf_-?p<q30j+;~&FIgX8d-dkTL#;si?T(8zaeaFfhEfZvO_ll>u_n1YJXCqi3Vog=A}XMT"
    b"96T=mlZ$FVhslL-G$DDv13<mIm}$5-c4e^P$zJpTsalRX3"
)
TINY_BLAZEPOSE = zlib.decompress(b85decode(_TFLITE))
"""Input (1, 256, 256, 3) with means r, g, b of the channels; outputs of 195 numbers, whose rows of five are
256 r, 256 g, 0, r + g + b, 0, and of one, the mean of r, g and b."""


def lit(rows: Array, kind: str = "int", size: Sequence[int | str] = ("height", "width")) -> bytes:
    """ONNX with input (1, height, width, 3) int32 or f4 and output (1, P, N): the brightest number / 255
    times the rows (P, N).
    """
    scaled = np.asarray(rows, np.float32)[None] / 255
    nodes = [
        _node("Cast", ["image"], "float", _number("to", FLOAT)),
        _node("ReduceMax", ["float"], "brightest", _numbers("axes", [1, 2, 3]) + _number("keepdims", 0)),
        _node("Mul", ["brightest", "rows"], "people"),
    ]
    graph = _graph(nodes, [_tensor("rows", scaled)], size, scaled.shape, INT if kind == "int" else FLOAT)
    return _integer(1, 8) + _field(8, _integer(2, 13)) + _field(7, graph)


def outside(location: str) -> bytes:
    """ONNX whose rows are said to lie in another file."""
    where = _field(13, _text(1, "location") + _text(2, location))
    rows = b"".join(_integer(1, n) for n in (1, 1, 56)) + _integer(2, FLOAT) + _text(8, "rows") + where
    graph = _graph([_node("Identity", ["rows"], "people")], [rows + _integer(14, 1)], (64, 64), (1, 1, 56))
    return _integer(1, 8) + _field(8, _integer(2, 13)) + _field(7, graph)


def _graph(
    nodes: Iterable[bytes],
    initial: Iterable[bytes],
    size: Sequence[int | str],
    out: Sequence[int],
    kind: int = INT,
) -> bytes:
    body = b"".join(_field(1, node) for node in nodes) + _text(2, "tiny")
    body += b"".join(_field(5, tensor) for tensor in initial)
    return body + _field(11, _value("image", kind, (1, *size, 3))) + _field(12, _value("people", FLOAT, out))


def _varint(value: int) -> bytes:
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def _integer(number: int, value: int) -> bytes:
    return _varint(number << 3) + _varint(value)


def _field(number: int, body: bytes) -> bytes:
    return _varint(number << 3 | 2) + _varint(len(body)) + body


def _text(number: int, text: str) -> bytes:
    return _field(number, text.encode())


def _node(operator: str, inputs: Sequence[str], output: str, attributes: bytes = b"") -> bytes:
    return b"".join(_text(1, name) for name in inputs) + _text(2, output) + _text(4, operator) + attributes


def _number(name: str, value: int) -> bytes:
    return _field(5, _text(1, name) + _integer(3, value) + _integer(20, 2))


def _numbers(name: str, values: Sequence[int]) -> bytes:
    return _field(5, _text(1, name) + b"".join(_integer(8, value) for value in values) + _integer(20, 7))


def _tensor(name: str, values: Array) -> bytes:
    shape = b"".join(_integer(1, n) for n in values.shape)
    return shape + _integer(2, FLOAT) + _text(8, name) + _field(9, values.tobytes())


def _value(name: str, kind: int, shape: Sequence[int | str]) -> bytes:
    sides = [_text(2, n) if isinstance(n, str) else _integer(1, n) for n in shape]
    return _text(1, name) + _field(
        2, _field(1, _integer(1, kind) + _field(2, b"".join(_field(1, s) for s in sides)))
    )


def movenet_row(score: float, **joints: tuple[float, float, float]) -> np.ndarray:
    """56 numbers; joints: x, y as shares, certainty."""
    row = np.zeros(56)
    for name, (x, y, certainty) in joints.items():
        at = 3 * MoveNetMultiPose.joints.index(name)
        row[at : at + 3] = y, x, certainty
    row[55] = score
    return row

"""Whatever arrives or stands in a file is read, or refused with a reason: inputs of hypothesis."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import msgpack
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from followspot.control.dispatch import answer_from_wire
from followspot.control.lifecycle import GetOrder, PrepareRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetHostStatus
from followspot.control.swap import ChangeOrder
from followspot.control.tapping import PlaceTaps
from followspot.errors import FollowspotError, InputError
from followspot.graph.load import load
from followspot.graph.plan_data import plan_from_data
from followspot.message_checks.sealing import seal
from followspot.messages import Header, InvalidMessage, Message, stamped
from followspot.room_document.room import room_of
from followspot.security.request_guard import Asked, Rejected, RequestGuard
from followspot.tracking import Blobs, Frame, Pairs, Tracks
from followspot.transport.wire import ALIGN, PREFIX
from followspot.transport.zenoh.codec import pack_as, unpack_as
from followspot.yaml.reader import parse

KINDS: tuple[type[Message], ...] = (Frame, Blobs, Pairs, Tracks)
SCALARS = st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text() | st.binary()
TREES = st.recursive(
    SCALARS, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20
)
JSON_TREES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)
WORDS = st.sampled_from(
    [
        "graph",
        "room",
        "stages",
        "uses",
        "in",
        "each",
        "with",
        "from",
        "delay",
        "cameras",
        "extends",
        "params",
        "inputs",
        "outputs",
        "seed",
        "sim.camera",
        "balls.mean",
        "camera",
        "a",
        "b",
        "a.out",
        "1",
        "-1",
        "${a}",
        "*x",
        "&x",
        "",
        "cameras[kind=x]",
    ]
)
GRAPHS = st.recursive(
    WORDS | st.integers() | st.none() | st.booleans() | st.floats(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=6),
    max_leaves=30,
)


def fate(read: Callable[[], object], *rejections: type[Exception]) -> object:
    """What was read, or why not; any other error is a failure."""
    try:
        return read()
    except rejections as error:
        return str(error)


def framed(head: bytes, body: bytes = b"", way: int = 0) -> bytes:
    size = PREFIX.size + len(head)
    return bytes([1, way]) + len(head).to_bytes(2, "little") + head + bytes(-size % ALIGN) + body


@given(st.binary(max_size=300), st.sampled_from(KINDS))
def test_any_bytes_are_a_message_or_refused(data: bytes, kind: type[Message]) -> None:
    assert fate(lambda: unpack_as(data, kind), InvalidMessage) != ""


@given(TREES, st.binary(max_size=200), st.sampled_from(KINDS), st.sampled_from((0, 1, 2, 3)))
def test_any_head_is_a_message_or_refused(tree: Any, body: bytes, kind: type[Message], way: int) -> None:
    assert fate(lambda: unpack_as(framed(msgpack.packb(tree), body, way), kind), InvalidMessage) != ""


@given(st.text(max_size=200))
@example("&a [*a]")
@example("a: &a {b: *a}")
@example("!!python/object/apply:os.system ['true']")
@example("[" * 5000)
def test_any_text_is_a_document_or_refused(text: str) -> None:
    assert fate(lambda: parse(text, "file.yaml"), InputError) != ""


@settings(deadline=None)
@given(GRAPHS)
def test_any_tree_is_a_graph_or_a_list_of_mistakes(
    tmp_path_factory: pytest.TempPathFactory, tree: Any
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(json.dumps(tree), encoding="utf-8")
    mistakes: list[Any] = []
    try:
        load(path, mistakes)
    except InputError as error:
        mistakes += error.mistakes
    assert all(mistake.text for mistake in mistakes)


@settings(deadline=None)
@given(GRAPHS)
def test_any_tree_is_a_room_or_refused(tree: Any) -> None:
    assert fate(lambda: room_of(parse(json.dumps(tree), "room.yaml"), ""), InputError) != ""


@given(JSON_TREES)
def test_any_order_plan_and_status_is_taken_or_refused(tree: Any) -> None:
    readers: tuple[Callable[[Any], object], ...] = (
        partial(answer_from_wire, GetOrder),
        partial(answer_from_wire, GetHostStatus),
        plan_from_data,
        *(kind.model_validate for kind in (PrepareRun, ChangeOrder, MoveOrder, PlaceTaps)),
    )
    for read in readers:
        assert fate(partial(read, tree), FollowspotError, ValueError) != ""


@given(st.text(max_size=80), st.binary(max_size=200))
def test_any_request_is_admitted_or_refused(key: str, payload: bytes) -> None:
    with pytest.raises(Rejected):
        RequestGuard("pc-left", {"stop"}).admit(Asked.of(key), payload)


@pytest.mark.parametrize("way", [1, 2])
def test_a_small_message_cannot_grow_beyond_what_its_head_says(way: int) -> None:
    whole = pack_as(_frame(), "lossless")
    head = whole[: PREFIX.size + int.from_bytes(whole[2:4], "little")]
    bomb = zlib.compress(bytes(50_000_000), 9)
    data = framed(head[PREFIX.size :], len(bomb).to_bytes(8, "little") + bomb, way)
    with pytest.raises(InvalidMessage, match="another size when decompressed"):
        unpack_as(data + bytes(-len(data) % ALIGN), Frame)


def test_a_picture_that_claims_to_be_huge_is_refused_before_it_is_decoded() -> None:
    whole = bytearray(pack_as(_frame(), "lossless"))
    start = whole.index(b"\x89PNG")
    whole[start + 16 : start + 24] = (65_000).to_bytes(4, "big") * 2
    with pytest.raises(InvalidMessage, match="65000 x 65000"):
        unpack_as(bytes(whole), Frame)


def test_a_file_that_unfolds_without_end_is_refused(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n + 1}: &a{n + 1} [{', '.join([f'*a{n}'] * 9)}]" for n in range(12)]
    with pytest.raises(InputError):
        parse("\n".join(lines), "laughs.yaml")


def _frame() -> Message:
    import numpy as np

    frame = Frame(camera="cam0", pixels=np.zeros((8, 8, 3), np.uint8))
    return stamped(seal(frame), Header("camera/cam0", 0, 1))

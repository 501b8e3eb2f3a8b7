"""Which members of a sender feed an input, where several places choose: what all of them choose is left."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import edges, planned
from tests.core.graph.files import ROOM

from followspot.errors import InputError

TAGGED = ROOM.replace("    kind: color\n", "    kind: color\n    tags: {zone: [hall, stage]}\n").replace(
    "    kind: infrared\n", "    kind: infrared\n    tags: {zone: hall}\n"
)
MAIN = """\
graph: main
room: room.yaml
stages:
  eyes:  {uses: room.source, each: cameras}
  outer: {graph: outer.yaml, in: {frames: OUTSIDE}}
"""
OUTER = """\
graph: outer
inputs: {frames: camera}
stages:
  camera: {uses: room.source, each: "MIDDLE"}
  inner:  {graph: inner.yaml, in: {frames: camera}}
"""
INNER = """\
graph: inner
inputs: {frames: camera}
stages:
  camera: {uses: room.source, each: "INSIDE"}
  all:    {uses: toy.mosaic, in: {frames: READ}}
"""


@pytest.mark.parametrize(
    ("outside", "middle", "inside", "read"),
    [
        ("eyes", "cameras[kind=infrared]", "cameras[zone=hall]", "camera"),
        ("eyes", "cameras[zone=hall]", "cameras[kind=infrared]", "camera"),
        ("{from: eyes, only: 'cameras[kind=infrared]'}", "cameras", "cameras[zone=hall]", "camera"),
        ("{from: eyes, only: 'cameras[kind=infrared]'}", "cameras[zone=hall]", "cameras", "camera"),
        ("{from: eyes, only: 'cameras[kind=infrared]'}", "cameras", "cameras",
         "{from: camera, only: 'cameras[zone=hall]'}"),
        ("eyes", "cameras[kind=infrared]", "cameras", "{from: camera, only: 'cameras[zone=hall]'}"),
    ],
)  # fmt: skip
def test_an_input_gets_what_all_that_choose_have_chosen(
    tmp_path: Path, outside: str, middle: str, inside: str, read: str
) -> None:
    main = MAIN.replace("OUTSIDE", outside)
    inner = INNER.replace("INSIDE", inside).replace("READ", read)
    plan = planned(tmp_path, main, room=TAGGED, outer=OUTER.replace("MIDDLE", middle), inner=inner)
    assert edges(plan) == ["eyes/cam1.out -> outer/inner/all.frames"]


def test_selectors_of_different_sets_choose_nothing_together(tmp_path: Path) -> None:
    main = MAIN.replace("OUTSIDE", "{from: eyes, only: 'zones[name=hall]'}")
    files = {"outer": OUTER.replace("MIDDLE", "cameras[kind=infrared]"), "inner": INNER}
    files["inner"] = INNER.replace("INSIDE", "cameras").replace("READ", "camera")
    with pytest.raises(InputError, match=r"no instance of stage \"eyes\" serves"):
        planned(tmp_path, main, room=TAGGED, **files)

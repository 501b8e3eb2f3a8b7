"""Every installed stage passes the kit; the kit finds what a careless author forgets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from followspot import Field, Message, Source, Stage, StageParams
from followspot.plugins.registry import catalogue, load_stage
from followspot.testing import check_stage, findings
from followspot.tracking import Blobs, Frame, ImageTracks


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_built_in_stage_keeps_every_promise(name: str) -> None:
    check_stage(load_stage(name))


class Careless(Stage):
    class Params(StageParams):
        size: float = Field(-1.0, gt=0, description="")

    def process(self, blobs: Blobs) -> Blobs:
        raise ZeroDivisionError


class NotYielding(Stage):
    """Says it is a source."""

    def process(self) -> Source[Message]:
        return iter(())


class Estranged(Stage):
    """Says something else together than alone."""

    per_camera = True

    def process(self, frame: Frame) -> ImageTracks:
        return ImageTracks.empty()

    @classmethod
    def process_together(cls, stages: Sequence[Stage], inputs: Sequence[object]) -> list[ImageTracks]:
        return [replace(ImageTracks.empty(), camera=stage.camera.name) for stage in stages]


def test_the_kit_names_each_broken_promise() -> None:
    broken = {finding.promise for finding in findings(Careless)}
    assert broken == {
        "is documented",
        "describes its parameters",
        "has defaults within its limits",
        "leaves empty inputs alone",
    }
    assert [f.promise for f in findings(NotYielding)] == ["has readable ports"]
    assert {f.promise for f in findings(Estranged)} == {"does together what it does alone"}
    with pytest.raises(AssertionError, match="write a docstring"):
        check_stage(Careless)

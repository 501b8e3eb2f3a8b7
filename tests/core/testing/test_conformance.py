"""Every installed stage passes the kit; the kit finds what a careless author forgets."""

from __future__ import annotations

import pytest

from followspot import Field, Message, Source, Stage, StageParams
from followspot.plugins.registry import catalogue, load_stage
from followspot.testing import check_stage, findings
from followspot.tracking import Blobs


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


def test_the_kit_names_each_broken_promise() -> None:
    broken = {finding.promise for finding in findings(Careless)}
    assert broken == {
        "is documented",
        "describes its parameters",
        "has defaults within its limits",
        "leaves empty inputs alone",
    }
    assert [f.promise for f in findings(NotYielding)] == ["has readable ports"]
    with pytest.raises(AssertionError, match="write a docstring"):
        check_stage(Careless)

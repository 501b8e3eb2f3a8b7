"""A graph that uses a former name of a parameter is told the name that the parameter has now."""

from __future__ import annotations

import pytest

from followspot.errors import Mistake
from followspot.graph.parameters import validated
from followspot.plugins.catalogue import catalogue
from followspot.plugins.former_names import new_names
from followspot.plugins.registry import load_stage
from followspot.stage import Stage
from followspot.stage_params import StageParams
from followspot.yaml.reader import parse

NAMES = [name for name, entry in catalogue().items() if entry.distribution == "followspot"]


@pytest.mark.parametrize("name", NAMES)
def test_every_former_name_is_refused_with_the_new_one(name: str) -> None:
    stage = load_stage(name)
    for old, new in new_names(stage).items():
        params = parse(f"{{{old}: 1}}", "graph.yaml").value
        mistakes: list[Mistake] = []
        validated(stage, f'stage "x" ({name})', params, parse("x", "graph.yaml").place, mistakes)
        (said,) = (m for m in mistakes if f'has no parameter "{old}"' in m.text)
        assert said.remedy.startswith(f'did you mean "{new}"?')


def test_the_detectors_and_the_tracker_know_former_names() -> None:
    assert new_names(load_stage("balls.kalman"))["fade"] == "fade_time"
    assert new_names(load_stage("balls.color_blobs"))["smallest"] == "minimum_area"


def test_a_plugin_without_the_file_renames_nothing() -> None:
    class Plain(Stage):
        class Params(StageParams):
            pass

    assert new_names(Plain) == {}

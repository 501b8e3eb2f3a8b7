"""Weights of cues are learnt from poses that are known: cues that tell the truth count, others do not."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import learn_weights

ROOM = Path(__file__).parent.parent.parent / "graphs/rooms/simulated_panorama.yaml"


def cues(told: tuple[bool, bool, bool]) -> np.ndarray:
    """Of 60 pictures with 50 poses; a cue that tells the truth is high there."""
    found = np.random.default_rng(2).uniform(0.3, 0.5, (60, 51, 3))
    found[:, 0, list(told)] += 0.2
    return found


@pytest.mark.parametrize("good", [0, 1, 2])
def test_the_cue_that_tells_the_truth_gets_the_weight(good: int) -> None:
    found = learn_weights.learnt(cues(tuple(k == good for k in range(3))))  # type: ignore[arg-type]
    weights = [found["params"][f"{cue}_weight"] for cue in learn_weights.CUES]
    assert int(np.argmax(weights)) == good
    assert found["after"] > found["before"] + 0.2
    assert found["pictures"] == found["held_out"] == 30


def test_cues_that_say_nothing_get_a_small_power() -> None:
    found = learn_weights.learnt(cues((False, False, False)))
    assert found["params"]["likelihood_power"] < 10
    assert found["after"] == pytest.approx(-np.log(51), abs=0.1)


@pytest.mark.thorough
def test_the_tool_prints_settings_of_the_pose_tracker(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(learn_weights, "BLOCK", 2)
    size = "--frames 12 --every 2 --json"
    monkeypatch.setattr(sys, "argv", ["learn_weights.py", "--room", str(ROOM), *size.split()])
    learn_weights.main()
    found = json.loads(capsys.readouterr().out)
    assert set(found["params"]) == {
        "edge_weight",
        "color_weight",
        "difference_weight",
        "gamma",
        "likelihood_power",
    }
    assert found["pictures"] > 2

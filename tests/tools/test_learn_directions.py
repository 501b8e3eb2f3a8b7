"""Cues of directions are learnt from known people, whatever a few of them show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from followspot_persons.pose_net.joint_headings import CUES, Cue
from learn_directions import TERMS, Crops, fitted, held_out

JOINTS = ("nose", "left_ear", "right_ear", "left_shoulder", "right_shoulder", "left_hip", "right_hip")
SCALE = 1.3


def crops(noise: float) -> Crops:
    """300 people whose joints fit all cues at 1.3 times the numbers; the last cue follows from the others."""
    rng = np.random.default_rng(4)
    chest = rng.uniform(-np.pi, np.pi, 300)
    face = chest + 0.3 * rng.standard_normal(300)
    place = {name: np.zeros(300) for name in JOINTS}
    for cue in CUES[:3]:
        half = SCALE / 2 * (cue.facing_chest * np.cos(chest) + cue.facing_face * np.cos(face))
        place[cue.joints[0]], place[cue.others[0]] = half, -half
    place["nose"] = SCALE * CUES[3].side_face * np.sin(face)
    column = np.stack([place[name] for name in JOINTS], axis=1) + noise * rng.standard_normal((300, 7))
    column[:20] += rng.uniform(-3, 3, (20, 7))  # what a network takes for a person
    height = rng.uniform(50, 90, 300)
    pixel = np.stack([column * height[:, None], np.zeros((300, 7))], axis=2)
    return Crops(JOINTS, pixel, np.ones((300, 7)), height, chest, face, np.arange(300) % 4)


@pytest.mark.parametrize("cue", CUES[:4], ids=lambda cue: "-".join((*cue.joints, *cue.others)))
def test_coefficients_are_found_beside_wild_people(cue: Cue) -> None:
    blank = replace(cue, sigma=9.0, **{term: 1.0 for term in TERMS if getattr(cue, term)})
    found = fitted(blank, crops(0.01), np.ones(300, bool))
    for term in TERMS:
        assert getattr(found, term) == pytest.approx(SCALE * getattr(cue, term), abs=0.005)
    assert 0.008 < found.sigma < 0.03


def test_directions_of_people_who_were_left_out_are_found() -> None:
    chest, face = held_out(crops(0.01))
    assert chest < 10
    assert face < 10
    far_chest, far_face = held_out(crops(0.3))
    assert far_chest > 2 * chest
    assert far_face > 2 * face

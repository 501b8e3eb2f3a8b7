"""Numbers of `followspot_persons.pose_net.joint_headings`, learnt from crops of people of known headings.

    python tools/learn_directions.py persons-dev/hog movenet_multipose.onnx

The folder has boxes.csv (file, body, torso_heading, head_pan, y0, y1) and its pictures, one person each. The
cues are printed as they stand in the module, then how well those of the others tell each body's directions.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from followspot import Array
from followspot.geometry import wrap
from followspot_persons.hog.model import DIRECTIONS
from followspot_persons.pose_net.contract import Network
from followspot_persons.pose_net.joint_headings import CUES, Cue, headings, shift_of
from followspot_persons.pose_net.loading import network
from followspot_persons.pose_net.movenet import MoveNetMultiPose
from followspot_persons.pose_net.regions import whole
from scripting import options_of

ROUNDS = 20
LEAST = 1e-3
"""Smallest residual that weighs by itself."""
TERMS = ("facing_chest", "side_chest", "facing_face", "side_face")
SIDE = 192
"""Shorter side of a crop in the network, px."""
FAINT, CERTAIN = 0.1, 0.2
"""Smallest score of a person, and of a joint that tells a direction."""


@dataclass(frozen=True, eq=False)
class Crops:
    """N people. joints: names; pixel: (N, J, 2); certainty: (N, J); height: (N,) px of the upper body;
    chest, face: (N,) rad relative to the camera; body: (N,) number of the person.
    """

    joints: Sequence[str]
    pixel: Array
    certainty: Array
    height: Array
    chest: Array
    face: Array
    body: Array


def main() -> None:
    """Learn and print."""
    parser = options_of(__doc__)
    parser.add_argument("crops", type=Path, help="folder with boxes.csv")
    parser.add_argument("model", type=Path, help="MoveNet MultiPose")
    given = parser.parse_args()
    crops = seen(given.crops, given.model)
    cues = [fitted(cue, crops, np.ones(len(crops.body), bool)) for cue in CUES]
    medians = held_out(crops)
    if given.json:
        print(
            json.dumps({"crops": len(crops.body), "held_out": medians, "cues": [vars(cue) for cue in cues]})
        )
        return
    for cue in cues:
        numbers = ", ".join(f"{term}={getattr(cue, term):.3f}" for term in TERMS if getattr(cue, term))
        print(f"Cue({cue.joints}, {cue.others}, {cue.sigma:.3f}, {numbers})")
    print(f"{len(crops.body)} crops; held out, median: chest {medians[0]:.1f} deg, face {medians[1]:.1f} deg")


def seen(folder: Path, model: Path) -> Crops:
    """What the network sees of the crops; those in which it sees nobody are left out."""
    rows = list(csv.DictReader((folder / "boxes.csv").open(encoding="utf-8")))
    net = network(model, MoveNetMultiPose)
    found = [_joints(folder / row["file"], net) for row in rows]
    kept = [(row, one) for row, one in zip(rows, found, strict=True) if one is not None]
    column = {key: np.array([float(row[key]) for row, _ in kept]) for key in ("body", "y0", "y1")}
    chest, pan = (np.array([float(row[key]) for row, _ in kept]) for key in ("torso_heading", "head_pan"))
    table = np.array([one for _, one in kept])
    height = column["y1"] - column["y0"]
    return Crops(
        net.decoder.joints, table[..., :2], table[..., 2], height, chest, chest + pan, column["body"]
    )


def _joints(picture: Path, network: Network) -> Array | None:
    """u, v, certainty of the surest person's joints, (J, 3); None if there is nobody."""
    pixels = np.asarray(cv2.cvtColor(np.asarray(cv2.imread(str(picture))), cv2.COLOR_BGR2RGB))
    region = whole(pixels.shape[1], pixels.shape[0], SIDE, network.decoder.multiple, network.size)
    (people,) = network.people([region.cut(pixels)])
    if not (people.score >= FAINT).any():
        return None
    best = int(people.score.argmax())
    return np.column_stack([region.in_picture(people.pixel[best]), people.certainty[best]])


def fitted(cue: Cue, crops: Crops, rows: Array) -> Cue:
    """The cue with the coefficients of least absolute deviations over these rows, and their sigma."""
    terms = [term for term in TERMS if getattr(cue, term)]
    angles = {"chest": crops.chest[rows], "face": crops.face[rows]}
    turns = {"facing": np.cos, "side": np.sin}
    split = [term.split("_") for term in terms]
    design = np.column_stack([turns[how](angles[what]) for how, what in split])
    shift = shift_of(cue, crops.joints, crops.pixel[rows], crops.height[rows])
    weight = np.ones(len(shift))
    for _ in range(ROUNDS):
        found = np.linalg.lstsq(design * weight[:, None], shift * weight, rcond=None)[0]
        weight = 1 / np.sqrt(np.maximum(np.abs(shift - design @ found), LEAST))
    sigma = 1.4826 * float(np.median(np.abs(shift - design @ found)))
    return replace(cue, sigma=sigma, **dict(zip(terms, found.tolist(), strict=True)))


def held_out(crops: Crops) -> list[float]:
    """Median errors of chest and face, degrees, of each body by the cues of the others."""
    errors: list[Array] = []
    for body in np.unique(crops.body):
        own = crops.body == body
        cues = [fitted(cue, crops, ~own) for cue in CUES]
        known = crops.certainty[own] >= CERTAIN
        tables = headings(crops.joints, crops.pixel[own], known, crops.height[own], cues)
        truth = (crops.chest[own], crops.face[own])
        errors.append(np.array([_apart(table, true) for table, true in zip(tables, truth, strict=True)]))
    return [float(value) for value in np.degrees(np.median(np.concatenate(errors, axis=1), axis=1))]


def _apart(table: Array, truth: Array) -> Array:
    """Distance of the mean direction about the likeliest from the truth, (N,) rad."""
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    share = np.exp(table) * (np.cos(angle - angle[table.argmax(axis=1)][:, None]) > 0.3)
    return np.asarray(np.abs(wrap(np.angle(share @ np.exp(1j * angle)) - truth)))


if __name__ == "__main__":
    main()

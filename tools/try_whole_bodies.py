"""What whole bodies are worth to the detector of upper bodies, for strangers in strange places.

    python tools/try_whole_bodies.py data/persons-dev/hog data/person-crops-inria --trials 1 2

The trials are those of `followspot train hog`, by number. Each learns a detector of upper bodies and one of
whole bodies, and prints which share of held-out people is found at 1 and at 0.1 false positives in 1,000
windows of held-out backgrounds, by upper bodies alone and with whole ones. A trial takes 6 to 8 minutes.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
from dataclasses import replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from followspot import Array
from followspot_persons.hog.model import HogModel, classify
from followspot_persons.hog.stage import Hog
from followspot_persons.hog.whole import raised
from followspot_persons.hog.whole_model import WholeModel
from followspot_persons.hog.window import cut
from followspot_train import figures, recipe
from followspot_train.linear import places, searched
from followspot_train.pictures import Background, read_folder
from followspot_train.recipe import Material, Searched, Split
from followspot_train.whole import learn
from scripting import options_of

SHARES = {"upper bodies": 0.0, "whole bodies": Hog.Params().whole_share}
"""Shares of the whole body that are compared."""
AT_ONCE = 500
"""Windows that are judged at once, which bounds memory."""


def main() -> None:
    """Learn, try, print."""
    parser = options_of(__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--trials", nargs="+", type=int, default=[1, 2, 3, 4])
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    pictures = reduce(add, [read_folder(folder) for folder in given.folders])
    rng = np.random.default_rng(given.seed)
    material = recipe.material(pictures, 0, rng, quiet)
    splits = list(recipe.splits(pictures))
    rows = [row for number in given.trials for row in tried(number, material, splits[number - 1], rng)]
    print(json.dumps(rows) if given.json else "\n".join(map(text, rows)))


def tried(number: int, material: Material, split: Split, rng: np.random.Generator) -> list[dict[str, Any]]:
    """The figures of a trial for each share."""
    model, whole = learnt(material, split, rng)
    strangers = [material.pictures.persons[number] for number in split.held]
    trial = recipe.attempt(material, replace(split, held_places=frozenset()), model)
    held = [b for b in material.pictures.backgrounds if b.place in split.held_places]
    scores = [scored(model, whole, background) for background in held]
    rows = []
    for column, (name, share) in enumerate(SHARES.items()):
        score = [
            raised(whole, share, person.pixels, person.box[None], np.array([said]))[0]
            for person, said in zip(strangers, trial.classification.score, strict=True)
        ]
        of_share = replace(
            trial,
            classification=replace(trial.classification, score=np.array(score)),
            backgrounds=folders(held, [columns[column] for columns in scores]),
        )
        rates = (figures.RATE, figures.THRESHOLD_RATE)
        found = [figures.recall([of_share], material.pictures.persons, rate) for rate in rates]
        rows.append({"trial": number, "judged_by": name, "found": found[0], "found_at_threshold": found[1]})
    return rows


def learnt(material: Material, split: Split, rng: np.random.Generator) -> tuple[HogModel, WholeModel]:
    """Detectors of upper and of whole bodies, from what is not held out."""
    model = recipe.learn(material, split, rng, quiet)
    persons = [material.pictures.persons[number] for number in split.learnt]
    backgrounds = [b for b in material.pictures.backgrounds if b.place not in split.held_places]
    return model, learn(persons, backgrounds, model.linear, rng, quiet)


def scored(model: HogModel, whole: WholeModel, background: Background) -> list[Array]:
    """Scores of the windows that are proposed in a background, for each share."""
    box = places(background.pixels, model.linear)
    parts = np.array_split(box, len(box) // AT_ONCE + 1)
    score = np.concatenate(
        [classify(model, [cut(background.pixels, b) for b in part]).score for part in parts]
    )
    return [raised(whole, share, background.pixels, box, score) for share in SHARES.values()]


def folders(backgrounds: list[Background], scores: list[Array]) -> dict[str, Searched]:
    """Scores and numbers of windows by folder."""
    found = {}
    for name in {background.folder for background in backgrounds}:
        own = [(b, s) for b, s in zip(backgrounds, scores, strict=True) if b.folder == name]
        windows = sum(searched(b.pixels) for b, _ in own)
        found[name] = Searched(np.concatenate([s for _, s in own]), windows)
    return found


def text(row: dict[str, Any]) -> str:
    """A row for people."""
    found = [(Path(name).name, row["found"][name], row["found_at_threshold"][name]) for name in row["found"]]
    parts = [f"{name} {100 * one['recall']:.1f}, {100 * few['recall']:.1f} %" for name, one, few in found]
    return f"trial {row['trial']}, {row['judged_by']}: {'; '.join(parts)}"


def quiet(_: str) -> None:
    """Show no progress."""


if __name__ == "__main__":
    main()

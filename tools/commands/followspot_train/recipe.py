"""Training of a model, and its trial on people and places that it never saw."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.hog.cells import cell_features
from followspot_persons.hog.channels import channels
from followspot_persons.hog.model import (
    DIRECTIONS,
    HEADINGS,
    Classification,
    HogModel,
    classify,
    classify_features,
)
from followspot_train import boosting, linear, network
from followspot_train.pictures import Background, Pictures
from followspot_train.windows import Windows, exact, found, missed

VIEWS, MISSES = 14, 5
"""Windows of each person that are learnt from: found and missed ones."""
DECEIVING = 300
"""Most windows of one background that pass the linear detector and train the network only."""
FOLDS = 4
RAW = np.array([1.0, 0.0], np.float32)
"""Calibration of scores that stay as they are."""
UNKNOWN = np.array([[1.0, 0.0], [1.0, 0.0]])
"""Trust in a network that was not tried on strangers: its own word."""

ReportProgress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Material:
    """All windows of persons, described once for all folds."""

    pictures: Pictures
    above: int
    """Most rows of a window that may lie above the picture, where the border is repeated."""
    found: Windows
    missed: Windows
    exact: Windows


@dataclass(frozen=True)
class Split:
    """Which persons (by number) and backgrounds (by place) are learnt from, and which are held out."""

    learnt: Array
    held: Array
    held_places: frozenset[str]


@dataclass(frozen=True, eq=False)
class Searched:
    """Held-out backgrounds of one folder: scores of the windows that were proposed, of so many windows."""

    scores: Array
    windows: int


@dataclass(frozen=True, eq=False)
class Trial:
    """The answers of a model for held-out pictures."""

    model: HogModel
    person: Array
    """(N,) numbers of the held-out persons."""
    linear: Array
    """(N,) score of the proposing detector for their exact windows, 0 at its threshold."""
    classification: Classification
    """For the exact windows."""
    found: Classification
    """For windows as a search finds them, with the true directions below."""
    torso: Array
    head: Array
    backgrounds: Mapping[str, Searched]
    """By folder."""


def material(
    pictures: Pictures, above: int, rng: np.random.Generator, report_progress: ReportProgress
) -> Material:
    """Cut and describe the windows of all persons."""
    report_progress(f"describing {len(pictures.persons)} persons")
    persons = pictures.persons
    seen = found(persons, VIEWS, above, rng)
    return Material(pictures, above, seen, missed(persons, MISSES, rng), exact(persons))


def splits(pictures: Pictures) -> Iterator[Split]:
    """Each fold holds out every fourth body and one place of each folder: strangers in strange places."""
    persons = pictures.persons
    folders = sorted({person.folder for person in persons})
    for fold in range(FOLDS):
        bodies, places = set[tuple[str, int]](), set[str]()
        for folder in folders:
            own = [person for person in persons if person.folder == folder]
            numbers = sorted({person.body for person in own if person.body >= 0})
            rooms = sorted({person.place for person in own})
            bodies |= {(folder, number) for number in numbers[fold::FOLDS]}
            places.add(rooms[fold % len(rooms)])
        there = np.array([person.place in places for person in persons])
        learnt = ~there & [(person.folder, person.body) not in bodies for person in persons]
        met = {(persons[i].folder, persons[i].body) for i in np.flatnonzero(learnt) if persons[i].body >= 0}
        strange = [(person.folder, person.body) not in met for person in persons]
        yield Split(np.flatnonzero(learnt), np.flatnonzero(there & strange), frozenset(places))


def learn(
    material: Material, split: Split, rng: np.random.Generator, report_progress: ReportProgress
) -> HogModel:
    """A model from the persons and places of a split that are not held out."""
    positive = material.found.where(np.isin(material.found.owner, split.learnt))
    near = material.missed.where(np.isin(material.missed.owner, split.learnt))
    backgrounds = [b for b in material.pictures.backgrounds if b.place not in split.held_places]
    weights, windows = linear.train(positive.features, backgrounds, material.above, rng, report_progress)
    report_progress("gathering what still passes")
    for background in backgrounds:
        passed, _ = linear.passing(background.pixels, weights, material.above)
        windows += list(passed[rng.permutation(len(passed))[:DECEIVING]])
    examples = _examples(positive, np.concatenate([near.cell_features, cell_features(windows)]))
    seen = np.concatenate([positive.channels, near.channels, channels(windows).astype(np.float16)])
    trees = boosting.train(
        np.hstack([examples.inputs.astype(np.float16), seen]), examples.person, rng, report_progress
    )
    grown = trees.feature, trees.threshold, trees.leaf
    learnt = network.train(examples, rng, report_progress)
    layers = learnt.hidden, learnt.hidden_bias, learnt.output, learnt.output_bias
    return HogModel(linear.finished(weights), *layers, UNKNOWN, *grown, RAW, **HEADINGS)


def _examples(positive: Windows, negative: Array) -> network.Examples:
    unknown = np.zeros((len(negative), DIRECTIONS), np.float32)
    return network.Examples(
        np.concatenate([positive.cell_features, negative]),
        np.repeat(np.array([1, 0], np.float32), [len(positive.cell_features), len(negative)]),
        tuple(np.concatenate([network.directions(a), unknown]) for a in (positive.torso, positive.head)),
    )


def attempt(material: Material, split: Split, model: HogModel) -> Trial:
    """Try a model on the samples that its split held out."""
    pictures = material.pictures
    alone = material.exact.where(split.held)
    among = material.found.where(np.isin(material.found.owner, split.held))
    held = [b for b in pictures.backgrounds if b.place in split.held_places]
    folders = sorted({b.folder for b in held})
    return Trial(
        model,
        alone.owner,
        alone.features @ model.linear[:-1] + model.linear[-1],
        classify_features(model, alone.cell_features, lambda rows: alone.channels[rows]),
        classify_features(model, among.cell_features, lambda rows: among.channels[rows]),
        among.torso,
        among.head,
        {name: _searched([b for b in held if b.folder == name], model, material.above) for name in folders},
    )


def _searched(backgrounds: Sequence[Background], model: HogModel, above: int) -> Searched:
    scores, count = [np.zeros(0)], 0
    for background in backgrounds:
        windows, searched = linear.passing(background.pixels, model.linear, above)
        scores.append(classify(model, windows).score)
        count += searched
    return Searched(np.concatenate(scores), count)


def everything(pictures: Pictures) -> Split:
    """Nothing is held out."""
    return Split(np.arange(len(pictures.persons)), np.zeros(0, int), frozenset())

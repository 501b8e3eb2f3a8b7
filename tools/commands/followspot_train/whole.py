"""`followspot train whole`: weights that tell whole people by the parts below their upper bodies."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add

import numpy as np

from followspot import Array
from followspot.errors import InputError
from followspot_persons.hog.channels import channels
from followspot_persons.hog.model import SHIPPED, load
from followspot_persons.hog.whole import windows, within
from followspot_persons.hog.whole_model import LAYOUT, WholeModel, save
from followspot_persons.hog.window import cut
from followspot_train import boosting, network
from followspot_train.command import check_writable, progress_printer
from followspot_train.linear import learning, places
from followspot_train.pictures import Background, Person, read_folder
from followspot_train.recipe import ReportProgress
from followspot_train.windows import as_found, as_missed, mirrored, relit

VIEWS, MISSES, PARTS = 12, 3, 3
"""Windows of each person that are learnt from: found and missed ones, and those of parts of a body."""
PART = (0.25, 0.65)
"""Sizes of what a part passes for, over the upper body's: an arm or a leg looks like a whole person, too."""
EACH = 300
"""Most windows of a background of `SQUARE` that are learnt from, as they are and again in another light."""
SQUARE = 320 * 240
"""px."""


def train_whole(args: argparse.Namespace) -> int:
    """Read, learn, write. Returns the exit code."""
    check_writable(args.out)
    pictures = reduce(add, [read_folder(folder) for folder in args.folders])
    linear = load(args.weights or SHIPPED).linear
    rng = np.random.default_rng(args.seed)
    save(learn(pictures.persons, pictures.backgrounds, linear, rng, progress_printer()), args.out)
    print(f"weights: {args.out}")
    return 0


def learn(
    persons: Sequence[Person],
    backgrounds: Sequence[Background],
    linear: Array,
    rng: np.random.Generator,
    report_progress: ReportProgress,
) -> WholeModel:
    """Network and trees that give the log-odds of a whole person, if as many windows show one as do not.

    linear: weights of the proposing detector in use; what passes its bar of learning in backgrounds is
    learnt from.
    """
    report_progress("describing whole people")
    true = _described([window for person in whole(persons) for window in _found(person, rng)])
    missed = [window for person in whole(persons) for window in _missed(person, rng)]
    missed += [window for person in persons for window in _parts(person, rng)]
    others = [
        window for background in backgrounds for window in _deceiving(background, learning(linear), rng)
    ]
    if not len(true) or not others:
        raise InputError.of("whole people, or places without people, are missing", "give pictures of both")
    false = _described(missed + others)
    seen, person = np.concatenate([true, false]), np.repeat([1.0, 0.0], [len(true), len(false)])
    trees = boosting.train(seen, person, rng, report_progress)
    layers = network.train(network.Examples(seen, person.astype(np.float32)), rng, report_progress)
    rarer = np.float32(np.log(len(false) / len(true)))
    leaf = trees.leaf.copy()
    leaf[0] += rarer
    return WholeModel(replace(layers, output_bias=layers.output_bias + rarer), replace(trees, leaf=leaf))


def whole(persons: Sequence[Person]) -> list[Person]:
    """Persons whose pictures have room for legs."""
    return [person for person in persons if within(person.box[None], person.pixels.shape)[0]]


def _described(images: Sequence[Array]) -> Array:
    return channels(images).astype(np.float16)


def _found(person: Person, rng: np.random.Generator) -> list[Array]:
    return [_seen(person, as_found(person.box, rng), rng) for _ in range(VIEWS)]


def _missed(person: Person, rng: np.random.Generator) -> list[Array]:
    return [_seen(person, as_missed(person.box, rng), rng) for _ in range(MISSES)]


def _parts(person: Person, rng: np.random.Generator) -> list[Array]:
    """Smaller windows of a person's picture, of which some have no room for legs and are left out."""
    height, width = person.pixels.shape[:2]
    tall = (person.box[3] - person.box[1]) * rng.uniform(*PART, PARTS)
    middle, top = rng.uniform(tall / 3, width - tall / 3), rng.uniform(0, height - 2 * tall)
    box = np.column_stack([middle - tall / 3, top, middle + tall / 3, top + tall])
    return [_seen(person, one, rng) for one in box[within(box, person.pixels.shape)]]


def _seen(person: Person, box: Array, rng: np.random.Generator) -> Array:
    return relit(mirrored(cut(person.pixels, box, layout=LAYOUT), rng)[0], rng)


def _deceiving(background: Background, linear: Array, rng: np.random.Generator) -> list[Array]:
    """Windows that look like upper bodies, with room for legs below."""
    box = places(background.pixels, linear)
    box = box[within(box, background.pixels.shape)]
    most = round(EACH * background.pixels.shape[0] * background.pixels.shape[1] / SQUARE)
    images = windows(background.pixels, box[rng.permutation(len(box))[:most]])
    return images + [relit(mirrored(image, rng)[0], rng) for image in images]

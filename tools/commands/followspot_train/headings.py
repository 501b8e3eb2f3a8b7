"""`followspot train headings`: a network that tells the directions of torso and head of upper bodies."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from followspot import Array
from followspot.errors import InputError
from followspot_persons.hog.cells import cell_features
from followspot_persons.hog.model import DIRECTIONS, SHIPPED, HogModel, load, save
from followspot_persons.hog.network import Network, outputs
from followspot_persons.hog.window import ABOVE, cut
from followspot_train import figures, network
from followspot_train.command import check_writable, prefixed, progress_printer
from followspot_train.pictures import Person, Pictures, read_folder
from followspot_train.recipe import FOLDS, ReportProgress, Split, splits
from followspot_train.tones import recoloured
from followspot_train.windows import CUT, as_found, mirrored, reaching_over, relit

WINDOWS = 12
"""Windows of each person that are learnt from."""
MEMBERS, UNITS = 4, 96
"""Networks whose logits are averaged, because single ones differ much on people who look unlike those of the
pictures; and the hidden units of each.
"""
PARTS = ("torso", "head")


@dataclass(frozen=True, eq=False)
class Samples:
    """Windows of persons: inputs (N, CELL_FEATURES), owner (N,) numbers, torso and head (N,) rad."""

    inputs: Array
    owner: Array
    torso: Array
    head: Array

    def of(self, persons: Array) -> Samples:
        """The windows of some persons, by number."""
        rows = np.isin(self.owner, persons)
        return Samples(*(array[rows] for array in vars(self).values()))


@dataclass(frozen=True, eq=False)
class Predictions:
    """Predictions of networks for windows of persons that they did not learn from."""

    torso: Array
    """(N, DIRECTIONS) logits."""
    head: Array
    owner: Array
    """(N,) numbers of the persons."""
    true_torso: Array
    """(N,) rad."""
    true_head: Array

    def where(self, rows: Array) -> Predictions:
        """Some of the windows."""
        return Predictions(*(array[rows] for array in vars(self).values()))


def train_headings(args: argparse.Namespace) -> int:
    """Train and test, write the weights, print the errors. Returns the exit code."""
    check_writable(args.out)
    base, report_progress = load(args.weights or SHIPPED), progress_printer()
    pictures = _with_headings(reduce(add, [read_folder(folder) for folder in args.folders]))
    rng = np.random.default_rng(args.seed)
    persons, above = pictures.persons, ABOVE if args.above else 0
    held_out, trials = sampled(persons, above, rng), []
    for number, split in enumerate(splits(pictures), start=1):
        of_trial = prefixed(report_progress, f"trial {number} of {FOLDS}: ")
        learnt = learn([persons[i] for i in split.learnt], above, rng, of_trial)
        trials.append(attempt(learnt, held_out, split))
    learnt = learn(persons, above, rng, prefixed(report_progress, "all: "))
    of_folder = by_folder(trials, persons)
    save(with_headings(base, learnt, list(of_folder.values())), args.out)
    report = {name: errors(predicted) for name, predicted in of_folder.items()}
    print(json.dumps(report) if args.json else text(report, args.out))
    return 0


def sampled(
    persons: Sequence[Person], above: int, rng: np.random.Generator, *, other_tones: bool = False
) -> Samples:
    """Each person `WINDOWS` times as a search finds it, relit, half of them mirrored.

    above: most rows of a window that may lie above the picture; other_tones: whether hair and skin change.
    """
    windows, owner, angles = [], [], []
    for number, person in enumerate(persons):
        for _ in range(WINDOWS):
            window, sign = mirrored(cut(person.pixels, as_found(person.box, rng)), rng)
            window = relit(recoloured(window, rng) if other_tones else window, rng)
            if above and rng.random() < CUT:
                window = reaching_over(window, int(rng.integers(1, above + 1)))
            windows.append(window)
            owner.append(number)
            angles.append((sign * person.torso, sign * person.head))
    torso, head = np.array(angles).T
    return Samples(cell_features(windows), np.array(owner), torso, head)


def learn(
    persons: Sequence[Person], above: int, rng: np.random.Generator, report_progress: ReportProgress
) -> Network:
    """A network of CELL_FEATURES inputs and 2 DIRECTIONS outputs: the mean of several, of other windows each.

    above: most rows of a window that may lie above the picture.
    """
    members = []
    for number in range(1, MEMBERS + 1):
        of_member = prefixed(report_progress, f"network {number} of {MEMBERS}: ")
        of_member(f"describing {len(persons)} persons")
        samples = sampled(persons, above, rng, other_tones=True)
        parts = network.directions(samples.torso), network.directions(samples.head)
        examples = network.Examples(samples.inputs, np.ones(len(samples.owner), np.float32), parts)
        members.append(network.train(examples, rng, of_member, UNITS))
    return mean(members)


def mean(members: Sequence[Network]) -> Network:
    """One network whose outputs are the means of those of several, without the first, which tells people."""
    output = np.concatenate([member.output[:, 1:] for member in members]) / len(members)
    bias = np.mean([member.output_bias[1:] for member in members], axis=0)
    hidden = np.concatenate([member.hidden for member in members], axis=1)
    return Network(hidden, np.concatenate([m.hidden_bias for m in members]), output, bias)


def attempt(learnt: Network, samples: Samples, split: Split) -> Predictions:
    """Predictions of a network for the persons that its split held out."""
    held = samples.of(split.held)
    predicted = outputs(learnt, held.inputs)
    return Predictions(
        predicted[:, :DIRECTIONS], predicted[:, DIRECTIONS:], held.owner, held.torso, held.head
    )


def joined(parts: Sequence[Predictions]) -> Predictions:
    """All windows of all parts."""
    return Predictions(
        *(np.concatenate(arrays) for arrays in zip(*(vars(p).values() for p in parts), strict=True))
    )


def by_folder(trials: Sequence[Predictions], persons: Sequence[Person]) -> dict[str, Predictions]:
    """All trials together, for each folder of the persons."""
    folder = np.array([person.folder for person in persons])
    found = {}
    for name in dict.fromkeys(folder.tolist()):
        rows = [folder[predicted.owner] == name for predicted in trials]
        found[name] = joined([predicted.where(row) for predicted, row in zip(trials, rows, strict=True)])
    return found


def with_headings(base: HogModel, learnt: Network, trials: Sequence[Predictions]) -> HogModel:
    """The weights with this network of headings, which is trusted as the folder where it errs most allows."""
    trust = [
        [
            figures.best_trust(getattr(predicted, part), getattr(predicted, f"true_{part}"))
            for predicted in trials
        ]
        for part in PARTS
    ]
    least = [[min(factor for factor, _ in each), max(share for _, share in each)] for each in trust]
    return replace(
        base,
        trust=np.array(least, np.float32),
        heading_hidden=learnt.hidden,
        heading_hidden_bias=learnt.hidden_bias,
        heading_output=learnt.output,
        heading_output_bias=learnt.output_bias,
    )


def errors(predicted: Predictions) -> dict[str, Any]:
    """Errors of both parts, in JSON types."""
    of_parts = {
        part: figures.heading_errors(getattr(predicted, part), getattr(predicted, f"true_{part}"))
        for part in PARTS
    }
    return {"persons": len(np.unique(predicted.owner)), **of_parts}


def text(report: dict[str, Any], out: object) -> str:
    """The figures for people."""
    lines = ["of people and places that were not learnt from:"]
    for name, numbers in report.items():
        lines.append(f"{name}, {numbers['persons']} pictures")
        lines += [figures.heading_line(part, numbers[part]) for part in PARTS]
    return "\n".join([*lines, f"weights: {out}"])


def _with_headings(pictures: Pictures) -> Pictures:
    """The persons whose headings are known. Raises InputError if there are too few."""
    known = tuple(p for p in pictures.persons if np.isfinite(p.torso) and np.isfinite(p.head))
    bodies = {(person.folder, person.body) for person in known}
    places = {person.place for person in known}
    if len(bodies) < FOLDS or len(places) < 2:
        found = f"{len(bodies)} bodies with headings in {len(places)} rooms"
        remedy = f"at least {FOLDS} bodies and 2 rooms are needed, because some are held out"
        raise InputError.of(f"too little to learn from: {found}", remedy)
    return replace(pictures, persons=known)

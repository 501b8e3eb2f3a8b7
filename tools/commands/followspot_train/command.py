"""`followspot train hog`: cross-validate on held-out people, learn from all, report."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import numpy as np

from followspot.errors import InputError, Mistake, require_unused
from followspot.notes import progress_is_shown
from followspot_persons.hog.model import HogModel, save
from followspot_persons.hog.window import ABOVE
from followspot_train import baseline, figures, recipe
from followspot_train.pictures import Pictures, read_folder
from followspot_train.recipe import ReportProgress, Trial


def train_hog(args: argparse.Namespace) -> int:
    """Read, try, learn, write, print. Returns the exit code."""
    report_progress = progress_printer()
    pictures = reduce(add, [read_folder(folder) for folder in args.folders])
    _check(pictures, args.out)
    rng = np.random.default_rng(args.seed)
    material = recipe.material(pictures, ABOVE if args.above else 0, rng, report_progress)
    trials = []
    for number, split in enumerate(recipe.splits(pictures), start=1):
        of_trial = prefixed(report_progress, f"trial {number} of {recipe.FOLDS}: ")
        model = recipe.learn(material, split, rng, of_trial)
        trials.append(recipe.attempt(material, split, model))
    model = recipe.learn(material, recipe.everything(pictures), rng, prefixed(report_progress, "all: "))
    save(calibrated(model, trials), args.out)
    report_progress("comparing with OpenCV's detector of people")
    report = {**figures_as_json(trials, pictures), "opencv": baseline.recall(pictures, figures.RATE)}
    print(json.dumps(report) if args.json else text(report, args.out))
    return 0


def calibrated(model: HogModel, trials: Sequence[Trial]) -> HogModel:
    """The model with 0 as its threshold, as sure of bodies and headings as the trials allow."""
    factor = figures.steepness(trials)
    calibration = np.array([factor, -factor * figures.threshold(trials)], np.float32)
    trust = np.array([figures.trust(trials, "torso"), figures.trust(trials, "head")])
    return replace(model, calibration=calibration, trust=trust)


def figures_as_json(trials: Sequence[Trial], pictures: Pictures) -> dict[str, Any]:
    """All figures in JSON types."""
    return {
        "persons": len(pictures.persons),
        "backgrounds": len(pictures.backgrounds),
        "windows": sum(s.windows for trial in trials for s in trial.backgrounds.values()),
        "found": figures.recall(trials, pictures.persons, figures.RATE),
        "found_at_threshold": figures.recall(trials, pictures.persons, figures.THRESHOLD_RATE),
        "torso": figures.headings(trials, "torso"),
        "head": figures.headings(trials, "head"),
    }


def text(report: dict[str, Any], out: Path) -> str:
    """The figures for people."""
    lines = [f"{report['persons']} persons, {report['backgrounds']} backgrounds; of strangers:"]
    for name, title in (
        ("found", "found at 1 false positive in 1,000 windows"),
        ("found_at_threshold", "found at the threshold, 1 in 10,000"),
        ("opencv", "OpenCV's detector, 1 in 1,000"),
    ):
        parts = [f"{kind} {100 * value['recall']:.1f} %" for kind, value in report[name].items()]
        lines.append(f"  {title}: {', '.join(parts)}")
    lines += [figures.heading_line(part, report[part]) for part in ("torso", "head")]
    return "\n".join([*lines, f"weights: {out}"])


def check_writable(out: Path) -> None:
    """Raises InputError if weights cannot be written to a file, or if it exists."""
    if mistakes := _unwritable(out):
        raise InputError(mistakes)
    require_unused(out)


def _unwritable(out: Path) -> list[Mistake]:
    if out.suffix == ".npz" and out.parent.is_dir():
        return []
    return [Mistake(None, f"cannot write {out}", "name a file .npz in a folder that exists")]


def _check(pictures: Pictures, out: Path) -> None:
    """Raises InputError if there are too few pictures, or if `out` cannot be written."""
    mistakes = _unwritable(out)
    bodies = {person.body for person in pictures.persons if person.body >= 0}
    rooms = {background.place for background in pictures.backgrounds}
    if len(bodies) < recipe.FOLDS or len(rooms) < 2:
        found = f"{len(bodies)} numbered bodies, backgrounds of {len(rooms)} rooms"
        remedy = f"at least {recipe.FOLDS} bodies and 2 rooms are needed, because some are held out"
        mistakes.append(Mistake(None, f"too little to learn from: {found}", remedy))
    if mistakes:
        raise InputError(mistakes)
    require_unused(out)


def prefixed(report_progress: ReportProgress, prefix: str) -> ReportProgress:
    """Reports of progress with words before each line."""
    return lambda text: report_progress(prefix + text)


def progress_printer() -> ReportProgress:
    """Shows progress, if that is wanted."""
    return _shown if progress_is_shown() else _unshown


def _shown(text: str) -> None:
    print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def _unshown(_: str) -> None:
    """Without a terminal there is no progress."""

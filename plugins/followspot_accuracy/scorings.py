"""The scores that this package offers to runs: of tracks and of poses (`followspot.scoring`)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.people import Poses, PoseTruth
from followspot.room import Room
from followspot.tracking import Tracks, Truth
from followspot_accuracy.persons.report import persons_table, persons_to_json
from followspot_accuracy.persons.scoring import PersonsScore, score_persons
from followspot_accuracy.persons.tables import PoseTruthTable, pose_truth_of, read_poses_csv
from followspot_accuracy.targets.report import table, to_json
from followspot_accuracy.targets.scoring import TargetScore, score
from followspot_accuracy.targets.tables import TruthTable, read_tracks_csv, truth_of


@dataclass(frozen=True)
class TargetScores:
    """The scores of all targets, by name."""

    targets: Mapping[str, TargetScore]
    noun = "target"

    def __str__(self) -> str:
        return table(self.targets)

    def to_data(self) -> dict[str, dict[str, Any]]:
        """The figures of each target."""
        return to_json(self.targets)


@dataclass(frozen=True)
class PersonScores:
    """The scores of all persons."""

    persons: PersonsScore
    noun = "person"

    def __str__(self) -> str:
        return persons_table(self.persons)

    def to_data(self) -> dict[str, dict[str, Any]]:
        """The figures of each person, and of all."""
        return persons_to_json(self.persons)


class TracksScoring:
    """Scores of tracks against true positions."""

    messages = Tracks
    truth = Truth

    def read_truth(self, messages: Iterable[Truth], room: Room) -> TruthTable:
        """True positions of all frames."""
        return truth_of(messages)

    def score(self, file: Path, truth: TruthTable, room: Room) -> TargetScores:
        """Scores of the tracks in a file. Raises InputError."""
        return TargetScores(score(read_tracks_csv(file), truth, room))


class PosesScoring:
    """Scores of poses against true poses."""

    messages = Poses
    truth = PoseTruth

    def read_truth(self, messages: Iterable[PoseTruth], room: Room) -> PoseTruthTable:
        """True poses of all frames."""
        return pose_truth_of(messages, viewpoint(room))

    def score(self, file: Path, truth: PoseTruthTable, room: Room) -> PersonScores:
        """Scores of the poses in a file. Raises InputError."""
        poses = read_poses_csv(file, lambda name: room.cameras[name].center[:2])
        return PersonScores(score_persons(poses, truth))


def viewpoint(room: Room) -> Array:
    """Point that directions and distances are measured from, (2,) m: the only camera, or the origin."""
    places = [camera.center[:2] for camera in room.cameras.values()]
    return places[0] if len(places) == 1 else np.zeros(2)

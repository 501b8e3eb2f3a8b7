"""Accuracy of tracks and poses against ground truth.

Of targets: read both (`read_tracks_csv`, `read_truth_csv`, or `truth_of` messages), `score` them, show the
result with `table` or `to_json`. Of persons: likewise `read_poses_csv`, `read_pose_truth_csv` or
`pose_truth_of`, `score_persons`, `persons_table`, `persons_to_json`. Pure numpy, independent
of the tracker.
"""

from followspot_accuracy.persons.report import persons_table, persons_to_json
from followspot_accuracy.persons.scoring import PersonScore, PersonsScore, score_persons
from followspot_accuracy.persons.tables import (
    PoseTable,
    PoseTruthTable,
    pose_truth_of,
    read_pose_truth_csv,
    read_poses_csv,
)
from followspot_accuracy.targets.report import table, to_json
from followspot_accuracy.targets.scoring import TargetScore, score
from followspot_accuracy.targets.tables import (
    TrackTable,
    TruthTable,
    read_tracks_csv,
    read_truth_csv,
    truth_of,
)

__all__ = [
    "PersonScore",
    "PersonsScore",
    "PoseTable",
    "PoseTruthTable",
    "TargetScore",
    "TrackTable",
    "TruthTable",
    "persons_table",
    "persons_to_json",
    "pose_truth_of",
    "read_pose_truth_csv",
    "read_poses_csv",
    "read_tracks_csv",
    "read_truth_csv",
    "score",
    "score_persons",
    "table",
    "to_json",
    "truth_of",
]

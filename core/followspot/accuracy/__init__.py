"""How good tracks and poses are, measured against ground truth.

Read both (`read_tracks_csv`, `read_truth_csv`, or `truth_of` messages; likewise `read_poses_csv`,
`read_pose_truth_csv`, `pose_truth_of`), `score` them, show the result with `table` or `to_json`. Pure
numpy; nothing here knows how the tracks were made. `targets` and `persons` hold the figures of each.
"""

from followspot.accuracy.persons.tables import (
    PoseTable,
    PoseTruthTable,
    pose_truth_of,
    read_pose_truth_csv,
    read_poses_csv,
)
from followspot.accuracy.targets.report import table, to_json
from followspot.accuracy.targets.scoring import TargetScore, score
from followspot.accuracy.targets.tables import (
    TrackTable,
    TruthTable,
    read_tracks_csv,
    read_truth_csv,
    truth_of,
)

__all__ = [
    "PoseTable",
    "PoseTruthTable",
    "TargetScore",
    "TrackTable",
    "TruthTable",
    "pose_truth_of",
    "read_pose_truth_csv",
    "read_poses_csv",
    "read_tracks_csv",
    "read_truth_csv",
    "score",
    "table",
    "to_json",
    "truth_of",
]

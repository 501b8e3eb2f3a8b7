"""How good tracks are, measured against ground truth.

Read both (`read_tracks_csv`, `read_truth_csv`, or `truth_of` messages), `score` them, show the result
with `table` or `to_json`. Pure numpy; nothing here knows how the tracks were made.
"""

from followspot.accuracy.report import table, to_json
from followspot.accuracy.scoring import TargetScore, score
from followspot.accuracy.tables import TrackTable, TruthTable, read_tracks_csv, read_truth_csv, truth_of

__all__ = [
    "TargetScore",
    "TrackTable",
    "TruthTable",
    "read_tracks_csv",
    "read_truth_csv",
    "score",
    "table",
    "to_json",
    "truth_of",
]

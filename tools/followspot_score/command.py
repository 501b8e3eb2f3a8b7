"""What `followspot score` does."""

from __future__ import annotations

import json
from pathlib import Path

from followspot.accuracy import read_tracks_csv, read_truth_csv, score, table, to_json
from followspot.room_file import load


def score_files(tracks: Path, truth: Path, room: Path | None, *, as_json: bool) -> str:
    """Scores of the tracks as a table or as JSON. Raises InputError."""
    scores = score(read_tracks_csv(tracks), read_truth_csv(truth), load(room) if room else None)
    return json.dumps(to_json(scores)) if as_json else table(scores)

"""What a script is told at the beginning and the end of a run, as warnings of Python."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.core.library.scripts import composed

import followspot as fs
from followspot.errors import FollowspotError
from followspot.tracking import Tracks


class Forgotten(fs.Stage):
    """A stage whose author forgot to return what it made."""

    def process(self, tracks: Tracks) -> Tracks:  # type: ignore[return]
        tracks.where(tracks.xyz[:, 2] < 1.0)


class Same(fs.Stage):
    """A stage that passes on what it gets."""

    def process(self, tracks: Tracks) -> Tracks:
        return tracks


class Single(fs.Stage):
    """A stage whose numbers have another precision than their column."""

    def process(self, tracks: Tracks) -> Tracks:
        return replace(tracks, xyz=tracks.xyz.astype(np.float32))


UNREAD = 'no stage reads what stage "low"'


def after_the_start(recwarn: pytest.WarningsRecorder) -> list[str]:
    """The warnings but for that of the check."""
    told = [str(warning.message) for warning in recwarn]
    assert UNREAD in told[0]
    return told[1:]


def test_a_script_is_warned_at_the_start_of_what_the_check_warns_of(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    run = fs.run(composed(), frames=1, out=tmp_path)
    (warning,) = recwarn.list
    assert UNREAD in str(warning.message)
    assert "or remove it" in str(warning.message), "the remedy"
    assert warning.filename == __file__, "the line of the script"
    run.close()


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (Forgotten, ["is a `return` missing in Forgotten.process?"]),
        (Single, ["last: xyz has dtype float32, declared float64", "broke their contract"]),
        (Same, []),
    ],
)
def test_a_script_is_warned_of_what_the_report_warns_of(
    kind: type[fs.Stage], said: list[str], tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    graph = composed()
    graph.add("last", kind, tracks=graph.port("track.tracks"))
    with fs.run(graph, frames=6, out=tmp_path, ports="last") as run:
        assert len(list(run["last"])) == (0 if said else 6)
    told = after_the_start(recwarn)
    assert len(told) == len(said)
    assert all(text in one for text, one in zip(said, told, strict=True))


def test_a_run_that_was_left_early_does_not_say_who_gave_nothing(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    with fs.run(composed(), out=tmp_path, ports="track.tracks") as run:
        next(iter(run["track.tracks"]))
    assert not after_the_start(recwarn)


def test_a_loop_behind_the_block_is_told_that_nothing_comes(tmp_path: Path) -> None:
    with fs.run(composed(), frames=3, out=tmp_path, ports="track.tracks") as run:
        pass
    with pytest.raises(FollowspotError, match="loop over it within the block of the run"):
        list(run["track.tracks"])


class Nowhere(fs.Stage):
    """Tracks without a place."""

    def process(self, tracks: Tracks) -> Tracks:
        return replace(tracks, xyz=np.full_like(tracks.xyz, np.nan))


def test_a_run_whose_files_cannot_be_scored_has_a_report(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    graph = composed()
    nowhere = graph.add("nowhere", Nowhere, tracks=graph.port("track.tracks"))
    graph.add("save", "sinks.csv", tracks=nowhere, path="tracks.csv")
    with fs.run(graph, frames=20, out=tmp_path) as run:
        assert run.wait().ok
    assert not list(run.report.accuracy)
    (told,) = after_the_start(recwarn)
    assert told.startswith(f"cannot score the run: {tmp_path / 'tracks.csv'}:")

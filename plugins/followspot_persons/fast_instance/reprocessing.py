"""Out-of-sequence measurements by reprocessing (Bar-Shalom et al. 2011): a late report of the slow instance
begins a track in its picture, and the pictures that were kept since then bring the track to the present.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from followspot.frame_times import NANOSECOND
from followspot_persons.fast_instance.pose_history import PoseHistory
from followspot_persons.likelihood.fitness import Picture
from followspot_persons.particles.track import Track

SPACING = 0.14
"""Smallest time between two kept pictures but the last, s: by 6.5 a second people are followed."""


@dataclass(frozen=True, eq=False)
class PastPicture:
    """A picture of a time, ns, and how bright it was (:class:`Illumination`)."""

    time: int
    picture: Picture
    light: float

    @classmethod
    def kept(cls, time: int, picture: Picture, light: float) -> PastPicture:
        """With edges of its own, for those of a message are lent."""
        own = replace(picture, magnitude=picture.magnitude.copy(), orientation=picture.orientation.copy())
        return cls(time, own, light)


@dataclass(frozen=True, eq=False)
class PastPictures:
    """The pictures of the last seconds, oldest first; the last one is always kept."""

    kept: tuple[PastPicture, ...] = ()

    def extended(self, new: PastPicture, longest: float) -> PastPictures:
        """These with a new picture, without those older than it by `longest`, s, or more; 0 keeps none."""
        kept = self.kept
        if len(kept) > 1 and kept[-1].time - kept[-2].time < SPACING * 1e9:
            kept = kept[:-1]
        return PastPictures(tuple(p for p in (*kept, new) if new.time - p.time < longest * 1e9))

    def between(self, first: int, last: int) -> Sequence[PastPicture]:
        """Those of later than the first time and earlier than the last one, ns."""
        return [p for p in self.kept if first < p.time < last]


def reprocessed(
    track: Track,
    time: int,
    pictures: Sequence[PastPicture],
    follow: Callable[[Track, float, PastPicture], Track],
) -> tuple[Track, PoseHistory]:
    """A track that began at a time, ns, after these later pictures, and where it was in each.

    follow: the track after a picture, so many seconds after the one before.
    """
    history = PoseHistory().extended(time, track.pose) if pictures else PoseHistory()
    for past in pictures:
        track = follow(track, (past.time - time) * NANOSECOND, past)
        time = past.time
        history = history.extended(time, track.pose)
    return track, history

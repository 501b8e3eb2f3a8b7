"""Poses of several cameras become one pose per person, in the room."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from followspot import Array, Field, Joined, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.geometry import wrap
from followspot.people import Poses
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import PREDICTED, TRACKED
from followspot_persons.nearest_neighbours import matched
from followspot_persons.pose_fusion.pose_table import PoseTable, fused_pose, pose_table
from followspot_persons.pose_fusion.position_filter import PositionTrack

SAME_MEMBER_FACTOR = 0.5
"""Factor on the distance to a camera's person that was assigned to this person before."""


@dataclass(frozen=True, eq=False)
class Fused:
    """A person of the room. pose, sigma: (6,); seen: time of the last pose, ns; hits: number of updates;
    members: camera's name -> the number of this person there.
    """

    number: int
    pose: Array
    sigma: Array
    track: PositionTrack
    confidence: float
    seen: int
    hits: int
    members: dict[str, int]


class Fusion(Stage):
    """Fuse the poses of several cameras: positions by their uncertain directions, headings by a vote.

    `room_poses` are poses in the room from other stages, such as `persons.associate`: they are weighted by
    the uncertainty that they state.
    """

    class Params(StageParams):
        direction_sigma: float = Field(
            0.012,
            gt=0,
            unit="rad",
            description="sigma of a person's direction from a camera; raising it trusts directions less",
        )
        distance_sigma: float = Field(
            0.07,
            gt=0,
            le=100,
            unit="1",
            description="relative sigma of a person's distance; raising it trusts distances less",
        )
        maximum_distance: float = Field(
            0.7,
            gt=0,
            unit="m",
            description="largest distance of a camera's pose from its person; raising it merges neighbours",
        )
        confirmation_frames: int = Field(
            3,
            ge=1,
            unit="frames",
            description="frames that confirm a tentative person; raising it avoids false persons",
        )
        maximum_missed_time: float = Field(
            0.6,
            gt=0,
            unit="s",
            description="time without a pose until a person is deleted; raising it bridges more",
        )
        memory_time: float = Field(
            120.0,
            gt=0,
            unit="s",
            description="time for which a deleted person's numbers are remembered; raising it gives persons "
            "their old numbers after longer absences",
        )

    params: Params

    def setup(self) -> None:
        self.people: list[Fused] = []
        self.deleted: list[Fused] = []
        self.numbers = 0
        self.time = -1

    def process(self, poses: Joined[Poses] = (), room_poses: Joined[Poses] = ()) -> Poses:
        poses = tuple(p for p in poses if p.camera in self.room.cameras)  # already fused poses have no camera
        poses += tuple(p for p in room_poses if not p.camera)
        if not poses:
            return Poses.empty()
        now = max(p.header.time for p in poses)
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        table = pose_table(poses, self.room.cameras, self.params.direction_sigma, self.params.distance_sigma)
        self.people = [replace(p, track=p.track.predicted(seconds)) for p in self.people]
        self.deleted = [replace(p, track=p.track.predicted(seconds)) for p in self.deleted]
        groups, free = self.assigned(table)
        free = [row for row in free if not self.is_outlier(table, row, groups)]
        self.people = [
            self.updated_person(person, table, groups[i], now) for i, person in enumerate(self.people)
        ]
        self.people += [self.initiated(table, rows, now) for rows in self.clustered(table, free)]
        self.delete_missed(now)
        return self.fused()

    def assigned(self, table: PoseTable) -> tuple[list[list[int]], list[int]]:
        """The rows that are assigned to each person, at most one per camera, and the unassigned rows."""
        groups: list[list[int]] = [[] for _ in self.people]
        free = set(range(len(table.pose)))
        if self.people:
            forecast = np.array([p.track.state[:2] for p in self.people])
            for camera in np.unique(table.camera):
                rows = np.flatnonzero(table.camera == camera)
                cost = np.linalg.norm(forecast[:, None] - table.pose[None, rows, :2], axis=2)
                cost *= np.where(self.known(table, rows), SAME_MEMBER_FACTOR, 1.0)
                in_gate = [p.track.in_gate(table.pose[rows, :2], table.covariance[rows]) for p in self.people]
                cost[~np.array(in_gate)] = np.inf
                for person, column in matched(cost, self.params.maximum_distance):
                    groups[person].append(int(rows[column]))
                    free.discard(int(rows[column]))
        return groups, sorted(free)

    def is_outlier(self, table: PoseTable, row: int, groups: list[list[int]]) -> bool:
        """Whether an unassigned row is an outlier of a known person, which initiates nobody.

        It is if its camera reported that person under this number before, or if it is near a person of whom
        its camera has no other row.
        """
        for person, rows in zip(self.people, groups, strict=True):
            if person.members.get(table.names[row]) == table.person[row]:
                return True
            near = np.linalg.norm(person.track.state[:2] - table.pose[row, :2]) < self.params.maximum_distance
            if near and all(table.camera[row] != table.camera[other] for other in rows):
                return True
        return False

    def known(self, table: PoseTable, rows: Array) -> Array:
        """Whether a camera's person was assigned to this one before: (people, rows)."""
        named = [(table.names[row], int(table.person[row])) for row in rows]
        return np.array([[p.members.get(name) == number for name, number in named] for p in self.people])

    def clustered(self, table: PoseTable, free: list[int]) -> list[list[int]]:
        """Unassigned rows, clustered if different cameras see the same position."""
        groups: list[list[int]] = []
        for row in sorted(free, key=lambda i: -table.confidence[i]):
            for group in groups:
                apart = np.linalg.norm(table.pose[row, :2] - table.pose[group[0], :2])
                if apart < self.params.maximum_distance and all(
                    table.camera[row] != table.camera[i] for i in group
                ):
                    group.append(row)
                    break
            else:
                groups.append([row])
        return groups

    def updated_person(self, person: Fused, table: PoseTable, rows: list[int], now: int) -> Fused:
        """The person after a picture; it coasts with its velocity if no camera saw it."""
        if not rows:
            place = np.maximum(person.track.sigma, person.sigma[:2])
            sigma = np.concatenate([place, person.sigma[2:]])
            return with_track_position(replace(person, sigma=sigma, confidence=0.0))
        pose, sigma, covariance = fused_pose(table, rows, person.pose)
        return with_track_position(
            Fused(
                person.number,
                pose,
                sigma,
                person.track.updated(pose[:2], covariance),
                float(table.confidence[rows].max()),
                now,
                person.hits + 1,
                person.members | members_of(table, rows),
            )
        )

    def initiated(self, table: PoseTable, rows: list[int], now: int) -> Fused:
        """A tentative person, or a deleted one that a camera has recognised where it can be by now."""
        pose, sigma, covariance = fused_pose(table, rows, None)
        members, track = members_of(table, rows), PositionTrack.initiated(pose[:2], covariance)
        new = Fused(0, pose, sigma, track, float(table.confidence[rows].max()), now, 1, members)
        for old in self.deleted:
            in_gate = old.track.in_gate(pose[None, :2], covariance[None])[0]
            if in_gate and members.items() & old.members.items():
                self.deleted.remove(old)
                return replace(new, number=old.number, hits=old.hits, members=old.members | members)
        return new

    def delete_missed(self, now: int) -> None:
        """Number the confirmed persons, and delete those that were missed too long."""
        people = []
        for person in self.people:
            age = (now - person.seen) * NANOSECOND
            if person.number == 0 and person.hits >= self.params.confirmation_frames:
                self.numbers += 1
                person = replace(person, number=self.numbers)
            if age <= self.params.maximum_missed_time:
                people.append(person)
            elif person.number:
                self.deleted.append(person)
        self.people = people
        self.deleted = [p for p in self.deleted if (now - p.seen) * NANOSECOND <= self.params.memory_time]

    def state(self) -> Any:
        people, deleted = to_plain(self.people), to_plain(self.deleted)
        return {"people": people, "deleted": deleted, "numbers": self.numbers, "time": self.time}

    def restore(self, state: Any) -> None:
        self.people = from_plain(list[Fused], state["people"])
        self.deleted = from_plain(list[Fused], state["deleted"])
        self.numbers, self.time = int(state["numbers"]), int(state["time"])

    def fused(self) -> Poses:
        """The confirmed persons."""
        people = sorted((p for p in self.people if p.number), key=lambda p: p.number)
        pose = np.array([p.pose for p in people]).reshape(-1, 6)
        return Poses(
            camera="",
            person=np.array([p.number for p in people], np.int32),
            state=np.array([TRACKED if p.seen == self.time else PREDICTED for p in people], np.uint8),
            xy=pose[:, :2].copy(),
            height=pose[:, 2].copy(),
            heading=wrap(pose[:, 3]),
            pan=pose[:, 4].copy(),
            tilt=pose[:, 5].copy(),
            sigma=np.array([p.sigma for p in people]).reshape(-1, 6),
            confidence=np.array([p.confidence for p in people]),
        )


def with_track_position(person: Fused) -> Fused:
    """The person with the pose at the position of its track."""
    return replace(person, pose=np.concatenate([person.track.state[:2], person.pose[2:]]))


def members_of(table: PoseTable, rows: list[int]) -> dict[str, int]:
    """Camera's name -> the number of a person there, of these rows."""
    return {table.names[i]: int(table.person[i]) for i in rows}

"""The fast instance: tracks known people by edges and colours at the cameras' rate (sections 4 and 5)."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from followspot import Array, Latest, Stage
from followspot.frame_times import NANOSECOND
from followspot.people import Appearances, Boxes, Gradients, Poses
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import PREDICTED, TRACKED, Frame
from followspot_persons.association import box_distance, matched
from followspot_persons.background.illumination import Illumination, in_usual_light
from followspot_persons.body.shape import read_shape, with_girth
from followspot_persons.body.view import view
from followspot_persons.color.difference import read_relations
from followspot_persons.color.pairs import telling_pairs
from followspot_persons.fast_instance.followed_person import Followed, poses_of
from followspot_persons.fast_instance.pose_tracker_params import PoseTrackerParams
from followspot_persons.fast_instance.reprocessing import PastPicture, PastPictures, reprocessed
from followspot_persons.fast_instance.slow_pose import SlowPose, astray, between, scattered_about
from followspot_persons.fast_instance.trail import carried_contact, carried_detection, carried_pose
from followspot_persons.likelihood.fitness import Detection, Fitness, Picture, pictured
from followspot_persons.likelihood.occlusion import covered
from followspot_persons.likelihood.walkable import Walkable
from followspot_persons.panorama import turn_of
from followspot_persons.particles.condensation import Search
from followspot_persons.particles.girth import girths_of
from followspot_persons.particles.identity_change import changed
from followspot_persons.particles.track import HIDDEN, Track, coasted, followed

JOINING = 0.1
"""Share of the particles that a pose of the slow instance replaces."""
NEAR = 0.6
"""Largest distance of a box from its person, in heights of the box."""


class PoseTracker(Stage):
    """Track the upper bodies and heads of known people in every picture."""

    per_camera = True
    state_lacks = "the pictures of the last `maximum_delay`"

    class Params(PoseTrackerParams):
        """The search, the cues and the life cycle."""

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.bodies = girths_of(self.shape)
        self.turn = turn_of(self.camera)
        p = self.params
        self.weights = p.weights
        self.walkable = Walkable.within(p.walkable)
        self.pairs = telling_pairs(self.shape, read_relations(p.color_relations, self.shape.names))
        self.search = Search(
            p.particles, p.random_share, p.ascent_share, p.search_rounds, p.local_search == "swarm"
        )
        self.people: dict[int, Followed] = {}
        self.known: dict[int, Track] = {}
        self.slow_poses: dict[int, SlowPose] = {}
        self.illumination = Illumination()
        self.past = PastPictures()
        self.boxed = -1
        self.time = -1

    def process(
        self, frame: Frame, gradients: Gradients, people: Latest[Appearances], boxes: Latest[Boxes]
    ) -> Poses:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        self.illumination = self.illumination.after(frame.pixels, now)
        seen = pictured(self.camera, frame, gradients)
        lit = self.illumination.light
        self.past = self.past.longer(PastPicture.kept(now, seen, lit), self.params.maximum_delay)
        if people is None:
            return poses_of(frame.camera, self.people)
        self.take_slow_poses(people, now)
        if seconds > self.params.maximum_missed_time:
            self.delete_missed(people, now)
        picture = self.in_light_of(people, seen, lit)
        told = self.detections(boxes, now, seconds)
        row = {number: i for i, number in enumerate(people.person.tolist())}
        self.change_identities(row)
        for number in self.nearest_first(row):
            fitness = self.fitness(people, row[number], picture, now, told.get(number))
            picture = self.follow(number, fitness, seconds, now)
        self.delete_missed(people, now)
        return poses_of(frame.camera, self.people)

    def change_identities(self, known: Collection[int]) -> None:
        """Let a share of each known person's particles be where those of the others are."""
        numbers = [n for n in self.people if n in known]
        particles = [self.people[n].track.particles for n in numbers]
        mixed = changed(particles, self.params.identity_change_share, self.rng)
        for number, places in zip(numbers, mixed, strict=True):
            person = self.people[number]
            self.people[number] = replace(person, track=replace(person.track, particles=places))

    def nearest_first(self, known: Collection[int]) -> list[int]:
        """Tracked and known persons, nearest first, because the nearer ones hide others."""
        eye = self.camera.center[:2]
        away = {n: float(np.hypot(*(p.track.pose[:2] - eye))) for n, p in self.people.items() if n in known}
        return sorted(away, key=lambda n: away[n])

    def in_light_of(self, people: Appearances, picture: Picture, light: float) -> Picture:
        """The picture, taken in a light, in that of the people's colours."""
        over = people.light * light / self.illumination.at(people.header.time)
        return replace(picture, colors=in_usual_light(picture.colors, over))

    def fitness(
        self, people: Appearances, row: int, picture: Picture, time: int, detection: Detection | None = None
    ) -> Fitness:
        """Weighs poses of one of the people in a picture of a time, ns."""
        colors = (people.mean[row].astype(np.float32), people.variance[row].astype(np.float32))
        return Fitness(
            picture,
            self.shape,
            self.weights,
            colors=colors if self.params.use_colors else None,
            detection=detection,
            contact=carried_contact(people.contact[row], (time - int(people.seen[row])) * NANOSECOND),
            pairs=self.pairs,
            walkable=self.walkable,
        )

    def take_slow_poses(self, people: Appearances, now: int) -> None:
        """Initiate persons that the slow instance has found, and mix its poses into the particles of tracked
        ones.
        """
        rows = zip(people.person.tolist(), people.pose, people.seen.tolist(), strict=True)
        for row, (number, pose, seen) in enumerate(rows):
            before = self.slow_poses.get(number)
            if (before is not None and seen <= before.time) or not np.isfinite(pose).all():
                continue
            self.slow_poses[number] = SlowPose(seen, pose)
            known = self.people.get(number)
            then = None if known is None else known.trail.at(seen)
            if known is not None and then is not None and astray(then, pose, self.camera.center):
                self.known[number], known = self.people.pop(number).track, None
            if known is None:
                self.people[number] = self.found(people, row, before, now)
            else:
                self.people[number] = self.corrected(known, people, row, then)

    def found(self, people: Appearances, row: int, before: SlowPose | None, now: int) -> Followed:
        """A person that the slow instance has found, followed through the pictures that were kept since.

        before: the slow pose of the person before this one, if any; now: ns.
        """
        number, seen = int(people.person[row]), int(people.seen[row])
        kept = self.past.between(seen, now)
        stature = (people.stature[row, 0], people.stature[row, 1])
        track = replace(self.initiated(number, before, seen if kept else now), stature=stature)
        track = replace(track, velocity=self.slow_poses[number].velocity(before)) if kept else track
        track, trail = reprocessed(track, seen, kept, partial(self.followed_then, people, row))
        return Followed(number, track, now, seen, trail=trail)

    def corrected(self, known: Followed, people: Appearances, row: int, then: Array | None) -> Followed:
        """A tracked person with particles about the pose that the slow instance reports.

        then: the track's pose (6,) when the slow instance saw the person, None if it is not known any more.
        """
        pose = people.pose[row]
        track = replace(known.track, stature=(people.stature[row, 0], people.stature[row, 1]))
        told = pose if then is None else carried_pose(pose, then, track.pose)
        joining = max(1, int(JOINING * len(track.particles)))
        track = track.joined_by(scattered_about(told, joining, self.rng))
        if people.contact[row, 1] == 0:
            track = replace(track, pose=between(track.pose, told, self.camera.center))
        return replace(known, track=track, boxed=max(known.boxed, int(people.seen[row])))

    def followed_then(
        self, people: Appearances, row: int, track: Track, seconds: float, past: PastPicture
    ) -> Track:
        """The track of one of the people after a picture that was kept."""
        picture = self.in_light_of(people, past.picture, past.light)
        fitness = self.fitness(people, row, picture, past.time)
        return followed(track, seconds, fitness, self.bodies, self.search, self.rng)

    def initiated(self, number: int, before: SlowPose | None, time: int) -> Track:
        """The track of a person that the slow instance has reported, at a time, with its past if any."""
        slow_pose = self.slow_poses[number]
        age = (time - slow_pose.time) * NANOSECOND
        pose = slow_pose.forecast(before, age)
        places = scattered_about(pose, self.params.particles, self.rng, age)
        past = self.known.get(number)
        return past.resumed(places) if past else Track.initiated(places)

    def detections(self, boxes: Boxes | None, now: int, seconds: float) -> dict[int, Detection]:
        """The detection of each person, once per message of the detector, carried to this picture."""
        if boxes is None or boxes.header.time <= self.boxed:
            return {}
        self.boxed = boxes.header.time
        if not len(boxes.box) or not self.people:
            return {}
        numbers = list(self.people)
        pose = np.array([coasted(self.people[n].track, seconds).pose for n in numbers])
        then = pose.copy()
        if self.boxed < now:
            past = [self.people[n].trail.at(self.boxed) for n in numbers]
            then = np.array([pose[i] if p is None else p for i, p in enumerate(past)])
        slow = [self.slow_poses[n] for n in numbers]
        expected = np.array([s.pose if s.time == self.boxed else then[i] for i, s in enumerate(slow)])
        distance = box_distance(view(self.camera, self.shape, expected).box, boxes.box, self.turn)
        told = {}
        for i, box in matched(distance, NEAR):
            self.people[numbers[i]] = replace(self.people[numbers[i]], boxed=self.boxed)
            seen = Detection.row(boxes, box)
            told[numbers[i]] = carried_detection(seen, self.camera, self.shape, then[i], pose[i])
        return told

    def follow(self, number: int, fitness: Fitness, seconds: float, now: int) -> Picture:
        """Track one person in one picture; returns the picture with this person's occlusions."""
        known, picture = self.people[number], fitness.picture
        track = followed(known.track, seconds, fitness, self.bodies, self.search, self.rng)
        unboxed = (self.boxed - known.boxed) * NANOSECOND
        least = self.params.minimum_likelihood_share
        enough = least + (1 - least) * min(1.0, unboxed / self.params.box_timeout)
        agrees = track.shown >= HIDDEN and track.likelihood >= enough * track.typical
        self.people[number] = replace(
            known,
            track=track,
            good=now if agrees else known.good,
            state=TRACKED if agrees else PREDICTED,
            trail=known.trail.longer(now, track.pose),
        )
        if not agrees or len(self.people) == 1:
            return picture
        return covered(picture, with_girth(self.shape, track.girth.mean), track.pose)

    def delete_missed(self, people: Appearances, now: int) -> None:
        """Delete persons that have left, or that either instance has missed too long."""
        known, left = set(people.person.tolist()), set(people.person[people.left > 0].tolist())
        for number, person in list(self.people.items()):
            unseen = (people.header.time - self.slow_poses[number].time) * NANOSECOND
            missed = (now - person.good) * NANOSECOND
            too_long = unseen > self.params.maximum_unseen_time or missed > self.params.maximum_missed_time
            if too_long or number in left or number not in known:
                self.known[number] = self.people.pop(number).track
        self.known = {number: track for number, track in self.known.items() if number in known}

    def state(self) -> Any:
        followed = {"people": self.people, "known": self.known, "slow_poses": self.slow_poses}
        told = {"illumination": self.illumination, "boxed": self.boxed, "time": self.time}
        return to_plain({**followed, **told})

    def restore(self, state: Any) -> None:
        self.people = from_plain(dict[int, Followed], state["people"])
        self.known = from_plain(dict[int, Track], state["known"])
        self.slow_poses = from_plain(dict[int, SlowPose], state["slow_poses"])
        self.illumination = from_plain(Illumination, state["illumination"])
        self.boxed, self.time = int(state["boxed"]), int(state["time"])

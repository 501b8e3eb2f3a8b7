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
from followspot_persons.background.illumination import Illumination, in_usual_light
from followspot_persons.body.shape import read_shape, with_girth
from followspot_persons.fast_instance.box_detections import person_detections
from followspot_persons.fast_instance.cue_model import CueModel
from followspot_persons.fast_instance.pose_history import propagated_contact, propagated_pose
from followspot_persons.fast_instance.pose_tracker_params import PoseTrackerParams
from followspot_persons.fast_instance.reprocessing import PastPicture, PastPictures, reprocessed
from followspot_persons.fast_instance.slow_pose import (
    SlowPose,
    halfway_distance,
    is_other_body,
    particles_about,
)
from followspot_persons.fast_instance.tracked_person import TrackedPerson, nearest_first, poses_of
from followspot_persons.likelihood.fitness import Detection, Fitness, Picture, pictured
from followspot_persons.likelihood.occlusion import covered
from followspot_persons.particles.condensation import Search
from followspot_persons.particles.girth import girths_of
from followspot_persons.particles.identity_change import changed
from followspot_persons.particles.track import FULLY_SHOWN, MINIMUM_SHOWN, Track, updated

SPAWN_SHARE = 0.1
"""Share of the particles that a pose of the slow instance replaces."""


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
        p = self.params
        self.cues = CueModel.of(p, self.shape)
        self.search = Search(
            p.particles, p.random_share, p.ascent_share, p.search_rounds, p.local_search == "swarm"
        )
        self.people: dict[int, TrackedPerson] = {}
        self.deleted_tracks: dict[int, Track] = {}
        self.slow_poses: dict[int, SlowPose] = {}
        self.illumination = Illumination()
        self.past = PastPictures()
        self.told = False
        self.boxed = -1
        self.time = -1

    def process(
        self, frame: Frame, gradients: Gradients, people: Latest[Appearances], boxes: Latest[Boxes]
    ) -> Poses:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        self.illumination = self.illumination.after(frame.pixels, now)
        present = pictured(self.camera, frame, gradients)
        light = self.illumination.light
        past = PastPicture.kept(now, present, light)
        self.past = self.past.extended(past, self.params.maximum_delay)
        if people is None:
            return poses_of(self.camera, self.people)
        self.correct_by_slow_poses(people, now)
        if seconds > self.params.maximum_missed_time:
            self.delete_missed(people, now)
        picture = self.in_light_of(people, present, light)
        detections = self.detections(boxes, now, seconds)
        row = {number: i for i, number in enumerate(people.person.tolist())}
        self.change_identities(row)
        for number in nearest_first(self.people, row, self.camera):
            fitness = self.fitness(people, row[number], picture, now, detections.get(number))
            picture = self.update(number, fitness, seconds, now)
        self.delete_missed(people, now)
        return poses_of(self.camera, self.people)

    def change_identities(self, known: Collection[int]) -> None:
        """Draw a share of each known person's particles from those of the others."""
        numbers = [n for n in self.people if n in known]
        particles = [self.people[n].track.particles for n in numbers]
        mixed = changed(particles, self.params.identity_change_share, self.rng)
        for number, drawn in zip(numbers, mixed, strict=True):
            person = self.people[number]
            self.people[number] = replace(person, track=replace(person.track, particles=drawn))

    def in_light_of(self, people: Appearances, picture: Picture, light: float) -> Picture:
        """The picture, taken in a light, with the colours that it would have in the light of the people's."""
        over = people.light * light / self.illumination.at(people.header.time)
        return replace(picture, colors=in_usual_light(picture.colors, over))

    def fitness(
        self, people: Appearances, row: int, picture: Picture, time: int, detection: Detection | None = None
    ) -> Fitness:
        """The fitness of poses of one of the people in a picture of a time, ns.

        If the colours are those of another shape's features, they do not count, and a warning says so once.
        """
        if not (self.told or self.cues.has_features_of(people)):
            self.told = True
            given, own = people.mean.shape[1], len(self.shape.names)
            self.context.warn(f"colours of {given} features do not count, {own} are in this stage's shape")
        return self.cues.fitness(people, row, picture, time, detection)

    def correct_by_slow_poses(self, people: Appearances, now: int) -> None:
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
            then = None if known is None else known.history.at(seen)
            if known is not None and then is not None and is_other_body(then, pose, self.camera.center):
                self.deleted_tracks[number], known = self.people.pop(number).track, None
            if known is None:
                self.people[number] = self.initiated(people, row, before, now)
            else:
                self.people[number] = self.corrected(known, people, row, then)

    def initiated(self, people: Appearances, row: int, before: SlowPose | None, now: int) -> TrackedPerson:
        """A person that the slow instance has found, tracked through the pictures that were kept since.

        before: the slow pose of the person before this one, if any; now: ns.
        """
        number, seen = int(people.person[row]), int(people.seen[row])
        kept = self.past.between(seen, now)
        stature = (people.stature[row, 0], people.stature[row, 1])
        track = replace(self.initiated_track(number, before, seen if kept else now), stature=stature)
        track = replace(track, velocity=self.slow_poses[number].velocity(before)) if kept else track
        track, history = reprocessed(track, seen, kept, partial(self.updated_by_past, people, row))
        return TrackedPerson(number, track, now, seen, history=history)

    def corrected(
        self, known: TrackedPerson, people: Appearances, row: int, then: Array | None
    ) -> TrackedPerson:
        """A tracked person with particles about the pose that the slow instance reports.

        then: the track's pose (6,) when the slow instance saw the person, None if it is not known any more.
        """
        pose = people.pose[row]
        track = replace(known.track, stature=(people.stature[row, 0], people.stature[row, 1]))
        present = pose if then is None else propagated_pose(pose, then, track.pose)
        count = max(1, int(SPAWN_SHARE * len(track.particles)))
        track = track.with_spawned(particles_about(present, count, self.rng))
        told = propagated_contact(people.contact[row], 0.0)
        if told is None or (known.track.shown < FULLY_SHOWN and not told.sure):
            track = replace(track, pose=halfway_distance(track.pose, present, self.camera.center))
        return replace(known, track=track, boxed=max(known.boxed, int(people.seen[row])))

    def updated_by_past(
        self, people: Appearances, row: int, track: Track, seconds: float, past: PastPicture
    ) -> Track:
        """The track of one of the people after a picture that was kept."""
        picture = self.in_light_of(people, past.picture, past.light)
        fitness = self.fitness(people, row, picture, past.time)
        return updated(track, seconds, fitness, self.bodies, self.search, self.rng)

    def initiated_track(self, number: int, before: SlowPose | None, time: int) -> Track:
        """A track at a time, ns, of a person that the slow instance has reported, new or deleted before."""
        slow_pose = self.slow_poses[number]
        age = (time - slow_pose.time) * NANOSECOND
        pose = slow_pose.forecast(before, age)
        particles = particles_about(pose, self.params.particles, self.rng, age)
        past = self.deleted_tracks.get(number)
        return past.resumed(particles) if past else Track.initiated(particles)

    def detections(self, boxes: Boxes | None, now: int, seconds: float) -> dict[int, Detection]:
        """The detection of each person, once per message of the detector, carried to this picture."""
        if boxes is None or boxes.header.time <= self.boxed:
            return {}
        self.boxed = boxes.header.time
        if not len(boxes.box) or not self.people:
            return {}
        found = person_detections(boxes, self.people, self.slow_poses, self.camera, self.shape, now, seconds)
        for number in found:
            self.people[number] = replace(self.people[number], boxed=self.boxed)
        return found

    def update(self, number: int, fitness: Fitness, seconds: float, now: int) -> Picture:
        """Track one person in one picture; returns the picture with this person's occlusions."""
        known, picture = self.people[number], fitness.picture
        track = updated(known.track, seconds, fitness, self.bodies, self.search, self.rng)
        unboxed = (self.boxed - known.boxed) * NANOSECOND
        least = self.params.minimum_likelihood_share
        enough = least + (1 - least) * min(1.0, unboxed / self.params.box_timeout)
        agrees = track.shown >= MINIMUM_SHOWN and track.likelihood >= enough * track.typical
        if not agrees:
            unseen = known.track.unseen.after(seconds, distance=False, direction=False)
            track = replace(track, unseen=unseen)
        self.people[number] = replace(
            known,
            track=track,
            agreed=now if agrees else known.agreed,
            state=TRACKED if agrees else PREDICTED,
            history=known.history.extended(now, track.pose),
        )
        if not agrees or len(self.people) == 1:
            return picture
        return covered(picture, with_girth(self.shape, track.girth.mean), track.pose)

    def delete_missed(self, people: Appearances, now: int) -> None:
        """Delete persons that have left, or that either instance has missed for too long."""
        known, left = set(people.person.tolist()), set(people.person[people.left > 0].tolist())
        for number, person in list(self.people.items()):
            unseen = (people.header.time - self.slow_poses[number].time) * NANOSECOND
            missed = (now - person.agreed) * NANOSECOND
            too_long = unseen > self.params.maximum_unseen_time or missed > self.params.maximum_missed_time
            if too_long or number in left or number not in known:
                self.deleted_tracks[number] = self.people.pop(number).track
        self.deleted_tracks = {n: track for n, track in self.deleted_tracks.items() if n in known}

    def state(self) -> Any:
        names = ("people", "deleted_tracks", "slow_poses", "illumination", "boxed", "time")
        return to_plain({name: getattr(self, name) for name in names})

    def restore(self, state: Any) -> None:
        self.people = from_plain(dict[int, TrackedPerson], state["people"])
        self.deleted_tracks = from_plain(dict[int, Track], state["deleted_tracks"])
        self.slow_poses = from_plain(dict[int, SlowPose], state["slow_poses"])
        self.illumination = from_plain(Illumination, state["illumination"])
        self.boxed, self.time = int(state["boxed"]), int(state["time"])

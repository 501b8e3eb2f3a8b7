"""How the slow instance's knowledge of one person changes with a picture (section 5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from followspot import Array, Camera
from followspot.frame_times import NANOSECOND
from followspot_persons.background.existence import (
    RIGID,
    STILL,
    THERE,
    Stirring,
    averaged,
    evidence_of,
    stirred,
)
from followspot_persons.background.floor_beside import body_before
from followspot_persons.background.floor_contact import Contact, Presence, presence
from followspot_persons.background.scene import Scene
from followspot_persons.body.shape import ShapeModel, with_girth
from followspot_persons.body.stature import USUAL, Stature, is_of_adult, sized
from followspot_persons.body.view import view
from followspot_persons.color.model import ColorModel, learnt
from followspot_persons.likelihood.fitness import Detection, Fitness, Picture, Weights, sampled
from followspot_persons.likelihood.walkable import Walkable
from followspot_persons.particles.condensation import Search
from followspot_persons.particles.spawning import spawned
from followspot_persons.particles.track import MINIMUM_SHOWN, Track, coasted, updated
from followspot_persons.slow_instance.appearance_params import AppearanceParams
from followspot_persons.slow_instance.box_assignment import FAR, NEAR, BoxAssignment
from followspot_persons.slow_instance.foreground_box import foreground_box, shares
from followspot_persons.slow_instance.known_person import KnownPerson, missed
from followspot_persons.slow_instance.observation import Observation
from followspot_persons.slow_instance.part_box import Stood, by_size, stood
from followspot_persons.slow_instance.projected_bodies import ProjectedBodies

SHARP_VISIBILITY = 0.3
"""Cosine of the steepest view of a feature whose colour is learnt."""
JOINING = 0.3
"""Share of the particles that a box places anew, for people walk on between two pictures."""
TRUSTED = 12.0
"""Largest trust in a person."""


@dataclass(frozen=True, eq=False)
class PersonUpdate:
    """Updates a person by a box or by the foreground alone, and initiates one at a box; of one camera.

    girths: of :func:`girths_of`; assignment: says whose box it is; random:
    gives the generator of the stage, which is not made before its first use.
    """

    params: AppearanceParams
    shape: ShapeModel
    girths: ShapeModel
    weights: Weights
    walkable: Walkable | None
    bodies: ProjectedBodies
    assignment: BoxAssignment
    random: Callable[[], np.random.Generator]

    @property
    def camera(self) -> Camera:
        """The camera whose pictures these are."""
        return self.bodies.camera

    def initiated(
        self, detection: Detection, score: float, others: Array, seen: Observation
    ) -> KnownPerson | None:
        """A tentative person from one box; None if it is of a part, of no adult, or where nobody can be.

        others: (K, 4) px, upper bodies of known people.
        """
        particles = spawned(self.camera, detection, self.params.particles, self.random())
        known = self._stood(seen, detection, particles.mean(axis=0), USUAL, others)
        if known.part:
            particles = spawned(self.camera, known.detection, self.params.particles, self.random())
        pose, outside = particles.mean(axis=0), self.walkable and self.walkable.excludes(particles[:, :2])
        adult = is_of_adult(self.camera, known.detection.box)
        if outside or not adult or body_before(self.camera, seen.pixels, pose, others):
            return None
        return KnownPerson.tentative(
            particles,
            len(self.shape.names),
            score,
            seen.now,
            comparable=seen.background.median is not None,
            contact=known.contact,
            first=seen.pixels,
        )

    def after_box(
        self,
        person: KnownPerson,
        detection: Detection,
        score: float,
        picture: Picture,
        others: Array,
        seen: Observation,
    ) -> KnownPerson | None:
        """The person after a box: pose by edges, box and feet, colours by the pose; None if it was none.

        picture: with the occlusions by nearer people; others: (K, 4) px, their upper bodies. A box on a
        person whom they hide is theirs.
        """
        known = self._stood(seen, detection, person.track.pose, person.stature.estimate[0], others)
        moved = self._updated(person, known, picture, seen, joined=True)
        track = moved.track
        if track.shown < MINIMUM_SHOWN:
            longest = self.params.maximum_missed_time
            return missed(replace(person, track=track), 0.0, seen.now, longest, left=False)
        shown = presence(seen.scene, track.pose, others)
        stature = self._stature(person.stature, None if known.part else detection, shown)
        stirring = person.stirring.after(shown, seen.now)
        if stirring.furniture(seen.now):
            return replace(person, absent=True, left=True) if person.number else None
        share = averaged(person.foreground, shown)
        comparable = person.comparable or (share or 0.0) >= THERE
        return replace(
            moved,
            track=replace(track, stature=stature.estimate),
            stature=stature,
            foreground=share,
            comparable=comparable,
            colors=self._learnt(person.colors, track, picture),
            seen=seen.now,
            boxed=seen.now,
            left=False,
            stirring=stirring,
            first=self._unchanged(person, stirring, track.pose, others, seen),
            hits=person.hits + 1,
            trust=min(person.trust + score + evidence_of(share, comparable=comparable), TRUSTED),
        )

    def after_foreground(
        self, person: KnownPerson, mask: Array, picture: Picture, others: Array, seen: Observation
    ) -> KnownPerson | None:
        """The person after a picture without a box, at the foreground that it must be; None if there is none.

        mask: of :func:`foreground_box`, without people that have boxes; others: (K, 4) px, upper bodies of
        nearer people. Colours are not learnt.
        """
        if not self._boxed_lately(person, seen):
            return None
        there, box = self._unboxed(person, mask, seen)
        body_seen = view(self.camera, self.shape, there.pose[None])
        if box is None or self.assignment.fits_average_better(person, body_seen, box, picture):
            return None
        detection = Detection(box, np.zeros(0), np.zeros(0), certainty=0.0)
        known = self._stood(seen, detection, there.pose, person.stature.estimate[0], others)
        moved = self._updated(person, known, picture, seen, joined=known.part)
        shown = presence(seen.scene, moved.track.pose, others)
        stature = self._stature(person.stature, None, shown)
        track = replace(moved.track, stature=stature.estimate)
        return replace(moved, track=track, stature=stature, seen=seen.now, left=False)

    def after_part(self, person: KnownPerson, free: Array, seen: Observation) -> KnownPerson | None:
        """The person, held in place, after a picture that shows a part of the body; None if it shows none.

        free: (N,) bool, unassigned boxes.
        """
        shown = free & ~(seen.still & person.comparable)
        if not (
            self._boxed_lately(person, seen) and self.bodies.parts(seen.boxes.box[shown], [person]).any()
        ):
            return None
        return replace(person, track=replace(person.track, velocity=np.zeros(2)), seen=seen.now, left=False)

    def left(self, person: KnownPerson, mask: Array, free: Array, seen: Observation) -> bool:
        """Whether a person left: background at the expected place, and no other foreground near it.

        mask, free: of :func:`foreground_box`, with and without the people that have boxes.
        """
        there, box = self._unboxed(person, free, seen)
        expected = self.bodies.boxes([replace(person, track=there)])
        return person.comparable and box is None and bool(shares(self.camera, mask, expected)[0] < STILL)

    def _stood(
        self, seen: Observation, detection: Detection, pose: Array, stature: float, others: Array
    ) -> Stood:
        """A detection beside the floor, by background and picture; arguments of :func:`stood`."""
        return stood(self.camera, seen.pixels, seen.scene, detection, pose, stature, others)

    def _updated(
        self, person: KnownPerson, known: Stood, picture: Picture, seen: Observation, *, joined: bool
    ) -> KnownPerson:
        """The person's track after the picture of a detection, and where the person stands.

        known: the detection beside the floor; joined: whether a share of the particles begins there.
        """
        size = None if known.part else by_size(self.camera, known.detection)
        age = (seen.now - person.seen) * NANOSECOND
        distance = person.distance.later(known.contact, size, age)
        fitness = self._fitness(picture, known.detection, distance.contact or distance.sized)
        search = Search(self.params.particles)
        before = self._joined(person.track, known.detection) if joined else person.track
        track = updated(before, seen.seconds, fitness, self.girths, search, self.random())
        return replace(person, track=track, distance=distance)

    def _boxed_lately(self, person: KnownPerson, seen: Observation) -> bool:
        """Whether somebody is known, and had a box not long ago: what is no upper body may prolong this."""
        unboxed = (seen.now - person.boxed) * NANOSECOND
        return bool(person.number) and unboxed <= self.params.maximum_unboxed_time

    def _learnt(self, model: ColorModel, track: Track, picture: Picture) -> ColorModel:
        """The colours of a person after a picture, of the features that are seen from no steep angle."""
        body = with_girth(self.shape, track.girth.mean)
        seen = view(self.camera, body, track.pose[None])
        colors, inside = sampled(picture, seen)
        visible = seen.visibility[0] * inside[0]
        weight = np.where(visible >= SHARP_VISIBILITY, visible, 0.0)
        return learnt(model, colors[0].astype(float), weight, self.params.color_averaging_frames)

    def _stature(self, stature: Stature, detection: Detection | None, shown: Presence | None) -> Stature:
        """The stature after a picture. detection: of the whole upper body, if any; shown: of `presence`."""
        if detection is not None:
            stature = sized(stature, self.camera, detection.box, detection.certainty)
        return stature.stood(None if shown is None else shown.height)

    def _unchanged(
        self, person: KnownPerson, stirring: Stirring, pose: Array, others: Array, seen: Observation
    ) -> Array | None:
        """The picture of the first box if the person looks as in it to this day, else None."""
        first = None if stirring.most >= RIGID else person.first
        if first is not None and stirred(Scene(self.camera, seen.pixels, first, 1.0), pose, others):
            return None
        return first

    def _joined(self, track: Track, detection: Detection) -> Track:
        """The track with a share of its particles where a detection is."""
        count = int(JOINING * self.params.particles)
        return track.with_spawned(spawned(self.camera, detection, count, self.random()))

    def _fitness(self, picture: Picture, detection: Detection, contact: Contact | None) -> Fitness:
        """Weighs poses of a person by edges, box, feet and the limits of space."""
        return Fitness(
            picture, self.shape, self.weights, detection=detection, contact=contact, walkable=self.walkable
        )

    def _unboxed(self, person: KnownPerson, mask: Array, seen: Observation) -> tuple[Track, Array | None]:
        """Where a person is expected, and the upper body (4,) px in the foreground near there, if any."""
        there = coasted(person.track, seen.seconds)
        expected = self.bodies.boxes([replace(person, track=there)])[0]
        reach = (NEAR + FAR * seen.seconds) / 2 * (expected[3] - expected[1])
        return there, foreground_box(self.camera, mask, expected, person.stature.estimate[0], reach)

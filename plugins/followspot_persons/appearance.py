"""The slow instance: finds people by detector and edges, and learns their appearance (section 5)."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from followspot import Array, Stage
from followspot.frame_times import NANOSECOND
from followspot.people import Appearances, Boxes, Gradients
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import Frame
from followspot_persons.acquaintance import Acquaintance, missed
from followspot_persons.appearance_params import AppearanceParams
from followspot_persons.background import Background
from followspot_persons.bodies import Bodies
from followspot_persons.body_view import view
from followspot_persons.box_assignment import FAR, NEAR, BoxAssignment
from followspot_persons.color.difference import read_relations
from followspot_persons.color.model import learnt
from followspot_persons.condensation import Search
from followspot_persons.existence import EVIDENCE, RIGID, STILL, THERE, averaged, evidence_of, stirred
from followspot_persons.fitness import Detection, Fitness, Picture, Weights, pictured, sampled
from followspot_persons.floor_contact import Contact, presence
from followspot_persons.foreground_box import STEP, foreground_box, shares, without_others
from followspot_persons.foreground_people import completed
from followspot_persons.girth import girths_of
from followspot_persons.illumination import Illumination
from followspot_persons.observation import Observation
from followspot_persons.occlusion import Shades
from followspot_persons.panorama import turn_of
from followspot_persons.part_box import stood
from followspot_persons.recognition import Recognition
from followspot_persons.reported import reported
from followspot_persons.scene import Scene
from followspot_persons.shape import read_shape, with_girth
from followspot_persons.spawning import spawned
from followspot_persons.stature import USUAL, sized
from followspot_persons.track import HIDDEN, Track, coasted, followed
from followspot_persons.walkable import Walkable

SHARP_VISIBILITY = 0.3
"""Cosine of the steepest view of a feature whose colour is learnt."""
JOINING = 0.3
"""Share of the particles that a box places anew, for people walk on between two pictures."""
TRUSTED = 12.0
"""Largest trust in a person."""


class Appearance(Stage):
    """Find people with a detector, fit the body model, learn their colours, and recognise them.

    A successor knows the people that have numbers. It learns the background anew, for pictures do not travel.
    """

    per_camera = True
    state_lacks = "the background and people without a number"

    class Params(AppearanceParams):
        """Finding, learning and remembering persons."""

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.relations = read_relations(self.params.color_relations, self.shape.names)
        self.girths = girths_of(self.shape)
        self.bodies = Bodies(self.camera, self.shape)
        p = self.params
        self.weights = Weights(real_valued=p.real_valued_boxes)
        self.walkable = Walkable.within(p.walkable)
        self.recognition = Recognition(p.confirmation_score, p.minimum_likeness, self.relations)
        self.assignment = BoxAssignment(self.camera, self.shape, self.relations, p.specific_beats_generic)
        self.background = Background(turn_of(self.camera))
        self.illumination = Illumination()
        self.people: list[Acquaintance] = []
        self.numbers = 0
        self.time = -1
        self.pixels = np.empty((0, 0, 3), np.uint8)

    def process(self, frame: Frame, gradients: Gradients, boxes: Boxes) -> Appearances:
        seen = self.observed(frame, gradients, boxes)
        present = [p for p in self.people if not p.absent]
        pairs = self.assignment.pairs(
            present, seen.detections, seen.still, seen.upright, seen.picture, seen.now
        )
        known, shades = self.with_boxes(present, pairs, seen)
        kept = [p for _, p in sorted(known.items()) if p is not None]
        unboxed, rest = self.without_boxes(present, known, kept, shades, seen)
        kept += rest
        kept += self.newcomers(pairs, kept, unboxed, seen)
        memory = self.params.memory_time
        kept += [p for p in self.people if p.absent and (seen.now - p.seen) * NANOSECOND <= memory]
        self.people, self.numbers = self.recognition.applied(kept, self.numbers)
        self.background = self.background.after(self.pixels, seen.now, self.people_here())
        relations = self.relations if self.params.predict_colors else None
        return reported(self.people, frame.camera, len(self.shape.names), relations, self.illumination)

    def observed(self, frame: Frame, gradients: Gradients, boxes: Boxes) -> Observation:
        """What a picture shows beside the background: the detector's boxes, and those of the foreground."""
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        self.illumination = self.illumination.after(frame.pixels, now)
        picture = pictured(self.camera, frame, gradients, self.illumination.light)
        before, self.pixels = self.pixels, picture.colors.reshape(*frame.pixels.shape[:2], 3)
        self.scene = Scene.of(self.camera, self.pixels, self.background)
        mask = None if self.scene is None else self.scene.mask(STEP)
        detected = len(boxes.box)
        if self.scene is not None and mask is not None and self.params.foreground_boxes:
            boxes = completed(boxes, self.scene, mask, before)
        upright = np.arange(len(boxes.box)) >= detected
        shown = np.ones(len(boxes.box)) if mask is None else shares(self.camera, mask, boxes.box)
        detections = [Detection.row(boxes, row) for row in range(len(boxes.box))]
        detections[detected:] = [replace(d, certainty=0.0) for d in detections[detected:]]
        return Observation(picture, mask, boxes, detections, shown < STILL, upright, seconds, now)

    def with_boxes(
        self, present: Sequence[Acquaintance], pairs: list[tuple[int, int]], seen: Observation
    ) -> tuple[dict[int, Acquaintance | None], Shades]:
        """The people that have boxes, by row, None if the box was none; and what they hide.

        Nearest first, because the nearer ones hide the others. pairs: rows of people and boxes.
        """
        shades, known = Shades(seen.picture, seen.picture), dict[int, Acquaintance | None]()
        for i, box in sorted(pairs, key=lambda pair: self.bodies.distance(present[pair[0]])):
            person, taken = present[i], [j for k, j in pairs if known.get(k)]
            known[i] = None
            if person.number == 0 and self.assignment.on_others(seen.boxes, box, taken):
                continue
            others, uncovered = self.bodies.nearer(present, person), shades.of(person.number)
            found = seen.detections[box], float(seen.boxes.score[box])
            after = self.updated(person, *found, uncovered, others, seen.seconds, seen.now)
            if after is not None and not after.absent:
                body = with_girth(self.shape, after.track.girth.mean)
                shades = shades.behind(after.number, body, after.track.pose)
            known[i] = after
        return known, shades

    def without_boxes(
        self,
        present: Sequence[Acquaintance],
        known: Collection[int],
        boxed: Sequence[Acquaintance],
        shades: Shades,
        seen: Observation,
    ) -> tuple[list[Acquaintance], list[Acquaintance]]:
        """The people without boxes that the foreground shows, and all of them that remain.

        known: rows of those that have boxes; boxed: these people.
        """
        covered, shown, rest = self.bodies.boxes(boxed), list[Acquaintance](), list[Acquaintance]()
        for i in sorted(set(range(len(present))) - set(known)):
            after, left = None, False
            if seen.mask is not None:
                free = without_others(seen.mask, covered, self.camera)
                others = self.bodies.nearer(present, present[i])
                after = self.prolonged(present[i], free, shades.numbered, others, seen.seconds, seen.now)
                left = after is None and self.left(present[i], seen.mask, free, seen.seconds)
            shown += [after] if after else []
            longest = self.params.maximum_missed_time
            after = after or missed(present[i], seen.seconds, seen.now, longest, left=left)
            rest += [after] if after else []
        return shown, rest

    def newcomers(
        self,
        pairs: list[tuple[int, int]],
        kept: Sequence[Acquaintance],
        unboxed: Sequence[Acquaintance],
        seen: Observation,
    ) -> list[Acquaintance]:
        """Tentative people at boxes that are nobody's. unboxed: people whom the foreground alone shows."""
        least = self.params.minimum_score + EVIDENCE * seen.still
        new = self.assignment.unclaimed(seen.boxes, pairs, self.bodies.boxes(unboxed), least)
        covered, score = self.bodies.boxes(kept), seen.boxes.score
        found = [self.initiated(seen.detections[i], float(score[i]), covered, seen.now) for i in new]
        return [person for person in found if person is not None]

    def state(self) -> Any:
        people = [person for person in self.people if person.number]
        told = {"people": people, "numbers": self.numbers, "illumination": self.illumination}
        return to_plain({**told, "time": self.time})

    def restore(self, state: Any) -> None:
        self.people = from_plain(list[Acquaintance], state["people"])
        self.numbers, self.time = int(state["numbers"]), int(state["time"])
        self.illumination = from_plain(Illumination, state["illumination"])

    def updated(
        self,
        person: Acquaintance,
        detection: Detection,
        score: float,
        picture: Picture,
        others: Array,
        seconds: float,
        now: int,
    ) -> Acquaintance | None:
        """The person after a box: pose by edges, box and feet, colours by the pose; None if it was none.

        others: (K, 4) px, upper bodies of nearer people. The box on who is hidden by them is theirs.
        """
        known = stood(self.scene, detection, person.track.pose, person.stature.estimate[0], others)
        contact = person.contact_after(known.contact, seconds)
        fitness = self.fitness(picture, known.detection, contact)
        search = Search(self.params.particles)
        before = self.joined(person.track, known.detection)
        track = followed(before, seconds, fitness, self.girths, search, self.rng)
        if track.shown < HIDDEN:
            return missed(replace(person, track=track), 0.0, now, self.params.maximum_missed_time, left=False)
        body = with_girth(self.shape, track.girth.mean)
        seen = view(self.camera, body, track.pose[None])
        colors, inside = sampled(picture, seen)
        visible = seen.visibility[0] * inside[0]
        weight = np.where(visible >= SHARP_VISIBILITY, visible, 0.0)
        stature = person.stature
        if not known.part:
            stature = sized(stature, self.camera, detection.box, detection.certainty)
        shown = presence(self.scene, track.pose, others)
        stature = stature.stood(None if shown is None else shown.height)
        stirring = person.stirring.after(shown, now)
        if stirring.furniture(now):
            return replace(person, absent=True, left=True) if person.number else None
        first = None if stirring.most >= RIGID else person.first
        if first is not None and stirred(Scene(self.camera, self.pixels, first, 1.0), track.pose, others):
            first = None
        share = averaged(person.foreground, shown)
        comparable = person.comparable or (share or 0.0) >= THERE
        model = learnt(person.colors, colors[0].astype(float), weight, self.params.color_averaging_frames)
        return replace(
            person,
            track=replace(track, stature=stature.estimate),
            stature=stature,
            foreground=share,
            comparable=comparable,
            colors=model,
            seen=now,
            boxed=now,
            left=False,
            contact=contact,
            stirring=stirring,
            first=first,
            hits=person.hits + 1,
            trust=min(person.trust + score + evidence_of(share, comparable=comparable), TRUSTED),
        )

    def prolonged(
        self,
        person: Acquaintance,
        mask: Array,
        picture: Picture,
        others: Array,
        seconds: float,
        now: int,
    ) -> Acquaintance | None:
        """The person after a picture without a box, at the foreground that it must be; None if there is none.

        mask: of :func:`foreground_box`, without people that have boxes; others: (K, 4) px, upper bodies of
        nearer people. Colours are not learnt.
        """
        unboxed = (now - person.boxed) * NANOSECOND
        if not person.number or unboxed > self.params.maximum_unboxed_time:
            return None
        there, box = self.unboxed(person, mask, seconds)
        seen = view(self.camera, self.shape, there.pose[None])
        if box is None or self.assignment.stranger(person, seen, box, picture):
            return None
        detection = Detection(box, np.zeros(0), np.zeros(0))
        known = stood(self.scene, detection, there.pose, person.stature.estimate[0], others)
        contact = person.contact_after(known.contact, seconds)
        fitness = self.fitness(picture, known.detection, contact)
        search = Search(self.params.particles)
        before = self.joined(person.track, known.detection) if known.part else person.track
        track = followed(before, seconds, fitness, self.girths, search, self.rng)
        shown = presence(self.scene, track.pose, others)
        stature = person.stature.stood(None if shown is None else shown.height)
        track = replace(track, stature=stature.estimate)
        return replace(person, track=track, stature=stature, contact=contact, seen=now, left=False)

    def joined(self, track: Track, detection: Detection) -> Track:
        """The track with a share of its particles where a detection is."""
        count = int(JOINING * self.params.particles)
        return track.joined_by(spawned(self.camera, detection, count, self.rng))

    def fitness(self, picture: Picture, detection: Detection, contact: Contact | None) -> Fitness:
        """Weighs poses of a person by edges, box, feet and the limits of space."""
        return Fitness(
            picture, self.shape, self.weights, detection=detection, contact=contact, walkable=self.walkable
        )

    def unboxed(self, person: Acquaintance, mask: Array, seconds: float) -> tuple[Track, Array | None]:
        """Where a person is expected, and the upper body (4,) px in the foreground near there, if any."""
        there = coasted(person.track, seconds)
        expected = self.bodies.boxes([replace(person, track=there)])[0]
        reach = (NEAR + FAR * seconds) / 2 * (expected[3] - expected[1])
        return there, foreground_box(self.camera, mask, expected, person.stature.estimate[0], reach)

    def left(self, person: Acquaintance, mask: Array, free: Array, seconds: float) -> bool:
        """Whether a person left: background at the expected place, and no other foreground near it.

        mask, free: of :func:`foreground_box`, with and without the people that have boxes.
        """
        there, box = self.unboxed(person, free, seconds)
        expected = self.bodies.boxes([replace(person, track=there)])
        return person.comparable and box is None and bool(shares(self.camera, mask, expected)[0] < STILL)

    def people_here(self) -> Array:
        """Boxes of the upper bodies of people who surely are no part of the room, (K, 4) px."""
        return self.bodies.boxes(
            [p for p in self.people if not p.absent and p.number and (p.foreground or 0.0) >= THERE]
        )

    def initiated(self, detection: Detection, score: float, others: Array, now: int) -> Acquaintance | None:
        """A tentative person from one box; None if the box lies outside the limits of space.

        others: (K, 4) px, upper bodies of known people.
        """
        particles = spawned(self.camera, detection, self.params.particles, self.rng)
        known = stood(self.scene, detection, particles.mean(axis=0), USUAL, others)
        if known.part:
            particles = spawned(self.camera, known.detection, self.params.particles, self.rng)
        if self.walkable is not None and self.walkable.excludes(particles[:, :2]):
            return None
        return Acquaintance.tentative(
            particles,
            len(self.shape.names),
            score,
            now,
            comparable=self.background.median is not None,
            contact=known.contact,
            first=self.pixels,
        )

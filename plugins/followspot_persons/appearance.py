"""The slow instance: finds people by detector and edges, and learns their appearance (section 5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array, Stage
from followspot.people import Appearances, Boxes, Gradients
from followspot.tracking import Frame
from followspot_persons.acquaintance import Acquaintance, missed
from followspot_persons.appearance_params import AppearanceParams
from followspot_persons.background import Background, foreground
from followspot_persons.body_view import view
from followspot_persons.box_assignment import FAR, NANOSECOND, NEAR, BoxAssignment
from followspot_persons.color.difference import completed, read_relations
from followspot_persons.color.model import ColorModel, learnt
from followspot_persons.condensation import Search
from followspot_persons.existence import EVIDENCE, STILL, THERE, averaged, evidence_of
from followspot_persons.fitness import Detection, Fitness, Picture, Weights, pictured, sampled
from followspot_persons.floor_contact import Presence, presence
from followspot_persons.foreground_box import STEP, foreground_box, shares, without_others
from followspot_persons.girth import girths_of
from followspot_persons.illumination import Illumination
from followspot_persons.occlusion import covered
from followspot_persons.recognition import Recognition
from followspot_persons.shape import read_shape, with_girth
from followspot_persons.spawning import spawned
from followspot_persons.track import Track, coasted, followed

SHARP_VISIBILITY = 0.3
"""Cosine of the steepest view of a feature whose colour is learnt."""
JOINING = 0.3
"""Share of the particles that a box places anew, for people walk on between two pictures."""
TRUSTED = 12.0
"""Largest trust in a person."""


class Appearance(Stage):
    """Find people with a detector, fit the body model, learn their colours, and recognise them."""

    per_camera = True

    class Params(AppearanceParams):
        """Finding, learning and remembering persons."""

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.relations = read_relations(self.params.color_relations)
        self.bodies = girths_of(self.shape)
        self.weights = Weights()
        p = self.params
        self.recognition = Recognition(p.confirmation_score, p.minimum_likeness, self.relations)
        self.assignment = BoxAssignment(self.camera, self.shape, self.relations, p.specific_beats_generic)
        self.background = Background()
        self.illumination = Illumination()
        self.people: list[Acquaintance] = []
        self.numbers = 0
        self.time = -1

    def process(self, frame: Frame, gradients: Gradients, boxes: Boxes) -> Appearances:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        self.illumination = self.illumination.after(frame.pixels, now)
        picture = pictured(self.camera, frame, gradients, self.illumination.light)
        self.pixels = picture.colors.reshape(*frame.pixels.shape[:2], 3)
        self.light = self.background.light(self.pixels)
        mask = self.foreground()
        still = np.zeros(len(boxes.box), bool)
        if mask is not None:
            still = shares(self.camera, mask, boxes.box) < STILL
        detections = [Detection(*row) for row in zip(boxes.box, boxes.torso, boxes.head, strict=True)]
        present = [p for p in self.people if not p.absent]
        pairs = self.assignment.pairs(present, detections, still, picture, now)
        seen = picture
        for person, box in sorted(pairs, key=lambda pair: self.distance(present[pair[0]])):
            score = float(boxes.score[box])
            known = self.updated(present[person], detections[box], score, seen, seconds, now)
            seen = covered(seen, with_girth(self.shape, known.track.girth.mean), known.track.pose)
            present[person] = known
        boxless = set(range(len(present))) - {person for person, _ in pairs}
        kept = [p for i, p in enumerate(present) if i not in boxless]
        others, unboxed = self.boxes_of(kept), list[Acquaintance]()
        for i in sorted(boxless):
            after, left = None, False
            if mask is not None:
                free = without_others(mask, others, self.camera)
                after = self.prolonged(present[i], free, seen, seconds, now)
                left = after is None and self.left(present[i], mask, free, seconds)
            unboxed += [after] if after else []
            after = after or missed(present[i], seconds, now, self.params.maximum_missed_time, left=left)
            kept += [after] if after else []
        least = self.params.minimum_score + EVIDENCE * still
        new = self.assignment.unclaimed(boxes, pairs, self.boxes_of(unboxed), least)
        kept += [self.initiated(detections[i], float(boxes.score[i]), now) for i in new]
        memory = self.params.memory_time
        kept += [p for p in self.people if p.absent and (now - p.seen) * NANOSECOND <= memory]
        self.people, self.numbers = self.recognition.applied(kept, self.numbers)
        self.background = self.background.after(self.pixels, now, self.people_here())
        return self.appearances(frame.camera)

    def distance(self, person: Acquaintance) -> float:
        """Distance of a person from the camera, m."""
        return float(np.hypot(*(person.track.pose[:2] - self.camera.center[:2])))

    def updated(
        self,
        person: Acquaintance,
        detection: Detection,
        score: float,
        picture: Picture,
        seconds: float,
        now: int,
    ) -> Acquaintance:
        """The person after a box: pose by edges and box, colours by the pose."""
        fitness = Fitness(picture, self.shape, self.weights, detection=detection)
        search = Search(self.params.particles)
        told = spawned(self.camera, self.shape, detection, int(JOINING * search.particles), self.rng)
        before = person.track.joined_by(told)
        track = followed(before, seconds, fitness, self.bodies, search, self.rng)
        body = with_girth(self.shape, track.girth.mean)
        seen = view(self.camera, body, track.pose[None])
        colors, inside = sampled(picture, seen)
        visible = seen.visibility[0] * inside[0]
        weight = np.where(visible >= SHARP_VISIBILITY, visible, 0.0)
        stature = person.stature.sized(track.measured, float(self.camera.center[2]))
        shown = self.presence(track)
        if shown is not None and shown.height is not None:
            stature = stature.stood(shown.height)
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
            hits=person.hits + 1,
            trust=min(person.trust + score + evidence_of(share, comparable=comparable), TRUSTED),
        )

    def foreground(self) -> Array | None:
        """What differs from the background, (H / STEP, W / STEP) bool; None if the background is unknown."""
        median = self.background.median
        if median is None or self.light is None:
            return None
        return foreground(self.pixels[::STEP, ::STEP], median[::STEP, ::STEP], self.light)

    def presence(self, track: Track) -> Presence | None:
        """What the background tells of a person in this picture; None if it is not known."""
        median = self.background.median
        if median is None or self.light is None:
            return None
        box = view(self.camera, self.shape, track.pose[None]).box[0]
        return presence(self.camera, self.pixels, median, self.light, track.pose, box)

    def prolonged(
        self, person: Acquaintance, mask: Array, picture: Picture, seconds: float, now: int
    ) -> Acquaintance | None:
        """The person after a picture without a box, at the foreground that it must be; None if there is none.

        mask: of :func:`foreground_box`, without people that have boxes. Colours are not learnt.
        """
        unboxed = (now - person.boxed) * NANOSECOND
        if not (person.number and person.comparable) or unboxed > self.params.maximum_unboxed_time:
            return None
        there, box = self.unboxed(person, mask, seconds)
        seen = view(self.camera, self.shape, there.pose[None])
        if box is None or self.assignment.stranger(person, seen, box, picture):
            return None
        detection = Detection(box, np.zeros(0), np.zeros(0))
        fitness = Fitness(picture, self.shape, self.weights, detection=detection)
        search = Search(self.params.particles)
        track = followed(person.track, seconds, fitness, self.bodies, search, self.rng)
        shown = self.presence(track)
        stature = person.stature
        if shown is not None and shown.height is not None:
            stature = stature.stood(shown.height)
        track = replace(track, stature=stature.estimate)
        return replace(person, track=track, stature=stature, seen=now, left=False)

    def unboxed(self, person: Acquaintance, mask: Array, seconds: float) -> tuple[Track, Array | None]:
        """Where a person is expected, and the upper body (4,) px in the foreground near there, if any."""
        there = coasted(person.track, seconds)
        expected = self.boxes_of([replace(person, track=there)])[0]
        reach = (NEAR + FAR * seconds) / 2 * (expected[3] - expected[1])
        return there, foreground_box(self.camera, mask, expected, person.stature.estimate[0], reach)

    def left(self, person: Acquaintance, mask: Array, free: Array, seconds: float) -> bool:
        """Whether the camera sees background where it expects a person, and no other foreground nearby.

        mask, free: of :func:`foreground_box`, with and without the people that have boxes.
        """
        there, box = self.unboxed(person, free, seconds)
        expected = self.boxes_of([replace(person, track=there)])
        return person.comparable and box is None and bool(shares(self.camera, mask, expected)[0] < STILL)

    def people_here(self) -> Array:
        """Boxes of the upper bodies of people who surely are no part of the room, (K, 4) px."""
        return self.boxes_of(
            [p for p in self.people if not p.absent and p.number and (p.foreground or 0.0) >= THERE]
        )

    def boxes_of(self, people: list[Acquaintance]) -> Array:
        """Upper bodies of people, (K, 4) px."""
        poses = np.array([p.track.pose for p in people]).reshape(-1, 6)
        return view(self.camera, self.shape, poses).box

    def initiated(self, detection: Detection, score: float, now: int) -> Acquaintance:
        """A tentative person from one box."""
        particles = spawned(self.camera, self.shape, detection, self.params.particles, self.rng)
        return Acquaintance(
            number=0,
            track=Track.initiated(particles),
            colors=ColorModel.unseen(len(self.shape.names)),
            initiated=now,
            seen=now,
            hits=1,
            trust=score,
            comparable=self.background.median is not None,
        )

    def appearances(self, camera: str) -> Appearances:
        """The confirmed persons."""
        known = sorted((p for p in self.people if p.number), key=lambda p: p.number)
        features = len(self.shape.names)
        models = [
            completed(p.colors, self.relations) if self.params.predict_colors else p.colors for p in known
        ]
        return Appearances(
            camera=camera,
            person=np.array([p.number for p in known], np.int32),
            mean=np.array([m.mean for m in models]).reshape(-1, features, 3),
            variance=np.array([m.variance for m in models]).reshape(-1, features, 3),
            evidence=np.array([m.evidence for m in models]).reshape(-1, features),
            pose=np.array([p.track.pose for p in known]).reshape(-1, 6),
            stature=np.array([p.track.stature for p in known]).reshape(-1, 2),
            seen=np.array([p.seen for p in known], np.int64),
            left=np.array([p.left for p in known], np.uint8),
            light=self.illumination.light,
        )

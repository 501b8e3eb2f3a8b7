"""The slow instance: finds people by detector and edges, and learns what they look like (section 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from followspot import Array, Field, InputPath, Stage, StageParams
from followspot.people import Appearances, Boxes, Gradients
from followspot.tracking import Frame
from followspot_persons.association import box_distance, matched
from followspot_persons.body_view import view
from followspot_persons.color_difference import SHIPPED as SHIPPED_RELATIONS
from followspot_persons.color_difference import completed, read_relations
from followspot_persons.color_model import ColorModel, learnt
from followspot_persons.condensation import Search
from followspot_persons.fitness import Detection, Fitness, Picture, Weights, sampled
from followspot_persons.identity import same_person
from followspot_persons.panorama import full_turn
from followspot_persons.shape import SHIPPED as SHIPPED_SHAPE
from followspot_persons.shape import read_shape
from followspot_persons.spawning import spawned
from followspot_persons.track import Track, coasted, followed

NANOSECOND = 1e-9
SHARP_VISIBILITY = 0.3
"""Cosine of the steepest view of a feature whose colour is learnt."""
COLOR_SHARE = 0.6
"""Weight of colours against places when boxes are given to persons."""


@dataclass(frozen=True, eq=False)
class Acquaintance:
    """A person, known or not yet: number 0 until enough boxes have shown that somebody is there.

    seen: ns, of the last box; hits: boxes so far; absent: whether the person is away.
    """

    number: int
    track: Track
    colors: ColorModel
    seen: int
    hits: int = 1
    absent: bool = False


class Appearance(Stage):
    """Find people with a detector, fit the body model, learn their colours, and know them again."""

    per_camera = True

    class Params(StageParams):
        shape: InputPath = Field(SHIPPED_SHAPE, description="shape model")
        relations: InputPath = Field(SHIPPED_RELATIONS, description="how colours of features relate")
        particles: int = Field(200, ge=20, le=10_000, unit="1", description="per person")
        confirm: int = Field(
            3, ge=1, unit="1", description="boxes that make a person; raising it avoids false persons"
        )
        away: float = Field(
            1.5, gt=0, unit="s", description="time without a box after which a person is away"
        )
        keep: float = Field(
            120.0, gt=0, unit="s", description="time for which a person who is away is remembered"
        )
        score: float = Field(0.0, unit="1", description="lowest score of a box that begins a person")
        difference: bool = Field(True, description="predict the colours of unseen sides from the seen ones")
        memory: float = Field(
            30.0,
            ge=1,
            unit="1",
            description="pictures that colours are a mean of; raising it follows light and turns more slowly",
        )
        likeness: float = Field(
            0.0,
            unit="1",
            description="log-likelihood ratio from which a newcomer is somebody who was here before",
        )

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.relations = read_relations(self.params.relations)
        self.around = self.camera.size[0] if full_turn(self.camera) else 0
        self.weights = Weights()
        self.people: list[Acquaintance] = []
        self.numbers = 0
        self.time = -1

    def process(self, frame: Frame, gradients: Gradients, boxes: Boxes) -> Appearances:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        picture = pictured(self.camera, frame, gradients)
        detections = [Detection(*row) for row in zip(boxes.box, boxes.torso, boxes.head, strict=True)]
        present = [p for p in self.people if not p.absent]
        pairs = self.assigned(present, detections, picture, seconds)
        for person, box in pairs:
            present[person] = self.updated(present[person], detections[box], picture, seconds, now)
        missed = set(range(len(present))) - {person for person, _ in pairs}
        kept = [p for i, p in enumerate(present) if i not in missed]
        kept += [p for i in sorted(missed) if (p := self.missed(present[i], seconds, now))]
        free = set(range(len(detections))) - {box for _, box in pairs}
        kept += [self.begun(detections[i], now) for i in sorted(free) if boxes.score[i] >= self.params.score]
        gone = [p for p in self.people if p.absent and (now - p.seen) * NANOSECOND <= self.params.keep]
        self.people = self.recognised(kept, gone)
        return self.appearances(frame.camera)

    def assigned(
        self, people: list[Acquaintance], detections: list[Detection], picture: Picture, seconds: float
    ) -> list[tuple[int, int]]:
        """Pairs of person and box: near in the picture, and of the person's colours."""
        if not people or not detections:
            return []
        forecast = np.array([coasted(p.track, seconds).pose for p in people])
        boxes = np.array([d.box for d in detections])
        distance = box_distance(view(self.camera, self.shape, forecast).box, boxes, self.around)
        return matched(distance, 0.8)

    def updated(
        self, person: Acquaintance, detection: Detection, picture: Picture, seconds: float, now: int
    ) -> Acquaintance:
        """The person after a box: pose by edges and box, colours by the pose."""
        fitness = Fitness(picture, self.shape, self.weights, person.track.habits, None, detection)
        search = Search(self.params.particles)
        track = followed(
            person.track, seconds, fitness, fitness.likelihood, self.camera.center, search, self.rng
        )
        seen = view(self.camera, self.shape, track.pose[None])
        colors, inside = sampled(picture, seen)
        visible = seen.visibility[0] * inside[0]
        weight = np.where(visible >= SHARP_VISIBILITY, visible, 0.0)
        model = learnt(person.colors, colors[0].astype(float), weight, self.params.memory)
        return Acquaintance(person.number, track, model, now, person.hits + 1)

    def missed(self, person: Acquaintance, seconds: float, now: int) -> Acquaintance | None:
        """The person after a picture without a box; None for one whom nobody knows yet."""
        if person.number == 0 and person.hits < self.params.confirm:
            return replace(person, hits=person.hits - 1) if person.hits > 1 else None
        absent = (now - person.seen) * NANOSECOND > self.params.away
        return replace(person, track=coasted(person.track, seconds), absent=absent)

    def begun(self, detection: Detection, now: int) -> Acquaintance:
        """Somebody whom one box has shown."""
        particles = spawned(self.camera, self.shape, detection, self.params.particles, self.rng)
        return Acquaintance(0, Track.begun(particles), ColorModel.unseen(len(self.shape.names)), now)

    def recognised(self, here: list[Acquaintance], gone: list[Acquaintance]) -> list[Acquaintance]:
        """Everybody, newcomers with the number of one who was away and looks the same, or with a new one."""
        people = []
        for person in here:
            if person.number == 0 and person.hits >= self.params.confirm:
                person, gone = self.named(person, gone)
            people.append(person)
        return people + gone

    def named(
        self, person: Acquaintance, gone: list[Acquaintance]
    ) -> tuple[Acquaintance, list[Acquaintance]]:
        """A newcomer with a number, and those who are still away."""
        likeness = [
            same_person(
                person.colors, other.colors, (person.track.stature, other.track.stature), self.relations
            )
            for other in gone
        ]
        if likeness and max(likeness) >= self.params.likeness:
            known = gone[int(np.argmax(likeness))]
            merged = replace(person, number=known.number, colors=known.colors)
            return merged, [p for p in gone if p is not known]
        self.numbers += 1
        return replace(person, number=self.numbers), gone

    def appearances(self, camera: str) -> Appearances:
        """Everybody who has a number."""
        known = sorted((p for p in self.people if p.number), key=lambda p: p.number)
        features = len(self.shape.names)
        models = [completed(p.colors, self.relations) if self.params.difference else p.colors for p in known]
        return Appearances(
            camera=camera,
            person=np.array([p.number for p in known], np.int32),
            mean=np.array([m.mean for m in models]).reshape(-1, features, 3),
            variance=np.array([m.variance for m in models]).reshape(-1, features, 3),
            evidence=np.array([m.evidence for m in models]).reshape(-1, features),
            pose=np.array([p.track.pose for p in known]).reshape(-1, 6),
            seen=np.array([p.seen for p in known], np.int64),
        )


def pictured(camera: Any, frame: Frame, gradients: Gradients) -> Picture:
    """A frame and its gradients, flat, the colours smoothed a little against noise."""
    pixels = frame.pixels if frame.pixels.shape[2] == 3 else np.repeat(frame.pixels, 3, axis=2)
    colors: Array = cv2.blur(pixels, (3, 3)).reshape(-1, 3)
    return Picture(camera, gradients.magnitude.ravel(), gradients.orientation.ravel(), colors)

"""The fast instance: follows known people by edges and colours at the cameras' rate (sections 4 and 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array, Field, InputPath, Latest, Stage, StageParams
from followspot.people import Appearances, Boxes, Gradients, Poses
from followspot.tracking import PREDICTED, TRACKED, Frame
from followspot_persons.appearance import NANOSECOND, pictured
from followspot_persons.association import box_distance, matched
from followspot_persons.body_view import HEADING, view
from followspot_persons.condensation import Search, scattered
from followspot_persons.fitness import Detection, Fitness, Picture, Weights
from followspot_persons.girth import girths_of
from followspot_persons.panorama import full_turn
from followspot_persons.shape import SHIPPED as SHIPPED_SHAPE
from followspot_persons.shape import read_shape
from followspot_persons.track import Track, coasted, followed

SPAWN_SIGMA = np.array([0.06, 0.06, 0.03, 0.3, 0.3, 0.1])
"""Of particles about a pose that the slow instance told: m, m, m, rad, rad, rad."""
JOINING = 0.1
"""Share of the particles that a pose of the slow instance replaces."""


@dataclass(frozen=True, eq=False)
class Followed:
    """A person who is followed. good: ns, time of the last picture that agreed; state: as in `Poses`."""

    number: int
    track: Track
    good: int
    state: int = TRACKED


class PoseTracker(Stage):
    """Follow the upper bodies and heads of known people in every picture."""

    per_camera = True

    class Params(StageParams):
        shape: InputPath = Field(SHIPPED_SHAPE, description="shape model")
        particles: int = Field(300, ge=20, le=10_000, unit="1", description="per person")
        random: float = Field(
            0.15,
            ge=0,
            le=0.9,
            unit="1",
            description="share of particles placed at random; raising it leaves a wrong pose sooner",
        )
        climbing: float = Field(
            0.2,
            ge=0,
            le=1,
            unit="1",
            description="share of particles, the best, that climb the fitness; 0: no gradient ascent",
        )
        color: bool = Field(True, description="weigh poses by the persons' colours, too")
        fade: float = Field(
            0.5,
            gt=0,
            lt=1,
            unit="1",
            description="share of a person's usual likelihood below which a picture does not show the person",
        )
        gone: float = Field(
            0.6, gt=0, unit="s", description="time without such a picture after which a person is gone"
        )
        unseen: float = Field(
            2.0,
            gt=0,
            unit="s",
            description="time after which one is gone whom the slow instance does not see",
        )

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.bodies = girths_of(self.shape)
        self.around = self.camera.size[0] if full_turn(self.camera) else 0
        self.weights = Weights()
        self.search = Search(self.params.particles, self.params.random, self.params.climbing)
        self.people: dict[int, Followed] = {}
        self.heard: dict[int, int] = {}
        self.boxed = -1
        self.time = -1

    def process(
        self, frame: Frame, gradients: Gradients, people: Latest[Appearances], boxes: Latest[Boxes]
    ) -> Poses:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        if people is None:
            return self.poses(frame.camera)
        self.listen(people, now)
        picture = pictured(self.camera, frame, gradients)
        told = self.headings(boxes, seconds)
        for row, number in enumerate(people.person.tolist()):
            if number in self.people:
                colors = (people.mean[row].astype(np.float32), people.variance[row].astype(np.float32))
                self.follow(number, picture, colors, told.get(number), seconds, now)
        self.forget(people, now)
        return self.poses(frame.camera)

    def listen(self, people: Appearances, now: int) -> None:
        """Begin to follow whom the slow instance has seen, and let its poses take part."""
        for number, pose, seen in zip(people.person.tolist(), people.pose, people.seen.tolist(), strict=True):
            if seen <= self.heard.get(number, -1):
                continue
            self.heard[number] = seen
            known = self.people.get(number)
            if known is None:
                self.people[number] = Followed(
                    number, Track.begun(self.strewn(pose, self.params.particles)), now
                )
                continue
            track = known.track
            joining = max(1, int(JOINING * len(track.particles)))
            moved = pose.copy()
            moved[:2] += track.velocity * (now - seen) * NANOSECOND
            particles = np.concatenate([track.particles[joining:], self.strewn(moved, joining)])
            self.people[number] = replace(known, track=replace(track, particles=particles))

    def strewn(self, pose: Array, count: int) -> Array:
        """Particles about a pose, (count, 6); some turned anyhow, for a heading is easily wrong."""
        particles = pose + SPAWN_SIGMA * self.rng.standard_normal((count, 6))
        turned = count // 5
        particles[:turned] = scattered(particles[:turned], self.rng)
        return np.asarray(particles)

    def headings(self, boxes: Boxes | None, seconds: float) -> dict[int, Detection]:
        """What a detector said of the headings of each person, once for each of its messages."""
        if boxes is None or boxes.header.time <= self.boxed or not len(boxes.box) or not self.people:
            return {}
        self.boxed = boxes.header.time
        numbers = list(self.people)
        pose = np.array([coasted(self.people[n].track, seconds).pose for n in numbers])
        distance = box_distance(view(self.camera, self.shape, pose).box, boxes.box, self.around)
        return {
            numbers[person]: Detection(boxes.box[box], boxes.torso[box], boxes.head[box])
            for person, box in matched(distance, 0.6)
        }

    def follow(
        self,
        number: int,
        picture: Picture,
        colors: tuple[Array, Array],
        detection: Detection | None,
        seconds: float,
        now: int,
    ) -> None:
        """One person in one picture."""
        known = self.people[number]
        known_colors = colors if self.params.color else None
        fitness = Fitness(picture, self.shape, self.weights, colors=known_colors, detection=detection)
        track = followed(known.track, seconds, fitness, self.bodies, self.search, self.rng)
        agrees = track.likelihood >= self.params.fade * track.typical
        self.people[number] = Followed(
            number, track, now if agrees else known.good, TRACKED if agrees else PREDICTED
        )

    def forget(self, people: Appearances, now: int) -> None:
        """Stop following who does not appear any more."""
        known = set(people.person.tolist())
        for number, person in list(self.people.items()):
            silent = (now - self.heard.get(number, now)) * NANOSECOND > self.params.unseen
            if silent or number not in known or (now - person.good) * NANOSECOND > self.params.gone:
                del self.people[number]

    def poses(self, camera: str) -> Poses:
        """Everybody who is followed."""
        people = [self.people[number] for number in sorted(self.people)]
        pose = np.array([p.track.pose for p in people]).reshape(-1, 6)
        return Poses(
            camera=camera,
            person=np.array([p.number for p in people], np.int32),
            state=np.array([p.state for p in people], np.uint8),
            xy=pose[:, :2].copy(),
            height=pose[:, 2].copy(),
            heading=pose[:, HEADING].copy(),
            pan=pose[:, 4].copy(),
            tilt=pose[:, 5].copy(),
            sigma=np.array([p.track.sigma for p in people]).reshape(-1, 6),
            confidence=np.array([min(1.0, p.track.likelihood) for p in people]),
        )

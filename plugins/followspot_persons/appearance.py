"""The slow instance: finds people by detector and edges, and learns their appearance (section 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from followspot import Array, Stage
from followspot.frame_times import NANOSECOND
from followspot.people import Appearances, Boxes, Gradients
from followspot.plain_values import from_plain, to_plain
from followspot.tracking import Frame
from followspot_persons.background.background import Background
from followspot_persons.background.existence import EVIDENCE, STILL, THERE
from followspot_persons.background.illumination import Illumination
from followspot_persons.background.scene import Scene
from followspot_persons.body.shape import read_shape, with_girth
from followspot_persons.color.difference import read_relations
from followspot_persons.likelihood.fitness import Detection, Weights, pictured
from followspot_persons.likelihood.occlusion import Shades
from followspot_persons.likelihood.walkable import Walkable
from followspot_persons.panorama import turn_of
from followspot_persons.particles.girth import girths_of
from followspot_persons.slow_instance.appearance_params import AppearanceParams
from followspot_persons.slow_instance.box_assignment import BoxAssignment
from followspot_persons.slow_instance.foreground_box import STEP, shares, without_others
from followspot_persons.slow_instance.foreground_people import completed
from followspot_persons.slow_instance.known_person import KnownPerson, missed
from followspot_persons.slow_instance.observation import Observation
from followspot_persons.slow_instance.person_update import PersonUpdate
from followspot_persons.slow_instance.projected_bodies import ProjectedBodies
from followspot_persons.slow_instance.recognition import Recognition
from followspot_persons.slow_instance.reported import reported


class Appearance(Stage):
    """Find people with a detector, fit the body model, learn their colours, and recognise them.

    If the stage is swapped, its successor knows the people that have numbers. The successor learns the
    background anew, because the state contains no pictures.
    """

    per_camera = True
    state_lacks = "the background and people without a number"

    class Params(AppearanceParams):
        """Finding, learning and remembering persons."""

    params: Params

    def setup(self) -> None:
        self.shape = read_shape(self.params.shape)
        self.relations = read_relations(self.params.color_relations, self.shape.names)
        self.bodies = ProjectedBodies(self.camera, self.shape)
        p = self.params
        self.recognition = Recognition(p.confirmation_score, p.minimum_likeness, self.relations)
        self.assignment = BoxAssignment(self.camera, self.shape, self.relations, p.specific_beats_generic)
        self.update = PersonUpdate(
            params=p,
            shape=self.shape,
            girths=girths_of(self.shape),
            weights=Weights(real_valued=p.real_valued_boxes),
            walkable=Walkable.within(p.walkable),
            bodies=self.bodies,
            assignment=self.assignment,
            random=lambda: self.rng,
        )
        self.background = Background(turn_of(self.camera))
        self.illumination = Illumination()
        self.people: list[KnownPerson] = []
        self.numbers = 0
        self.time = -1
        self.pixels = np.empty((0, 0, 3), np.uint8)

    def process(self, frame: Frame, gradients: Gradients, boxes: Boxes) -> Appearances:
        seen = self.observed(frame, gradients, boxes)
        present = [p for p in self.people if not p.absent]
        expected = [p.expected(seen.seconds) for p in present]
        pairs = self.assignment.pairs(
            expected, seen.detections, seen.still, seen.upright, seen.picture, seen.now
        )
        known, shades = self.with_boxes(present, pairs, seen)
        kept = [p for _, p in sorted(known.items()) if p is not None]
        unboxed, rest = self.without_boxes(present, pairs, kept, shades, seen)
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
        scene = Scene.of(self.camera, self.pixels, self.background)
        mask = None if scene is None else scene.mask(STEP)
        detected = len(boxes.box)
        if scene is not None and mask is not None and self.params.foreground_boxes:
            boxes = completed(boxes, scene, mask, before)
        upright = np.arange(len(boxes.box)) >= detected
        shown = np.ones(len(boxes.box)) if mask is None else shares(self.camera, mask, boxes.box)
        detections = [Detection.row(boxes, row) for row in range(len(boxes.box))]
        detections[detected:] = [replace(d, certainty=0.0) for d in detections[detected:]]
        return Observation(
            picture=picture,
            pixels=self.pixels,
            background=self.background,
            scene=scene,
            mask=mask,
            boxes=boxes,
            detections=detections,
            still=shown < STILL,
            upright=upright,
            seconds=seconds,
            now=now,
        )

    def with_boxes(
        self, present: Sequence[KnownPerson], pairs: list[tuple[int, int]], seen: Observation
    ) -> tuple[dict[int, KnownPerson | None], Shades]:
        """The people that have boxes, by row, None if the box was none; and the pixels that they hide.

        They are updated from the nearest to the farthest, because nearer people hide the others. pairs: rows
        of people and boxes.
        """
        shades, known = Shades(seen.picture, seen.picture), dict[int, KnownPerson | None]()
        for i, box in sorted(pairs, key=lambda pair: self.bodies.distance(present[pair[0]])):
            person, taken = present[i], [j for k, j in pairs if known.get(k)]
            known[i] = None
            if person.number == 0 and self.assignment.on_others(seen.boxes, box, taken):
                continue
            others, uncovered = self.bodies.nearer(present, person), shades.of(person.number)
            found = seen.detections[box], float(seen.boxes.score[box])
            after = self.update.after_box(person, *found, uncovered, others, seen)
            if after is not None and not after.absent:
                body = with_girth(self.shape, after.track.girth.mean)
                shades = shades.behind(after.number, body, after.track.pose)
            known[i] = after
        return known, shades

    def without_boxes(
        self,
        present: Sequence[KnownPerson],
        pairs: list[tuple[int, int]],
        boxed: Sequence[KnownPerson],
        shades: Shades,
        seen: Observation,
    ) -> tuple[list[KnownPerson], list[KnownPerson]]:
        """The people without boxes that the foreground shows, and all of them that remain.

        Foreground is the nearest person's. pairs: rows of people and boxes; boxed: the people that have them.
        """
        known = {person for person, _ in pairs}
        free_box = np.ones(len(seen.boxes.box), bool)
        free_box[[box for _, box in pairs]] = False
        shown, rest = list[KnownPerson](), list[KnownPerson]()
        unboxed = set(range(len(present))) - known
        for i in sorted(unboxed, key=lambda i: self.bodies.distance(present[i])):
            after, left = None, False
            if seen.mask is not None:
                free = without_others(seen.mask, self.bodies.boxes([*boxed, *shown]), self.camera)
                others = self.bodies.nearer(present, present[i])
                after = self.update.after_foreground(present[i], free, shades.numbered, others, seen)
                left = after is None and self.update.left(present[i], seen.mask, free, seen)
            shown += [after] if after else []
            if after is None and not left:
                after = self.update.after_part(present[i], free_box, seen)
            longest = self.params.maximum_missed_time
            after = after or missed(present[i], seen.seconds, seen.now, longest, left=left)
            rest += [after] if after else []
        return shown, rest

    def newcomers(
        self,
        pairs: list[tuple[int, int]],
        kept: Sequence[KnownPerson],
        unboxed: Sequence[KnownPerson],
        seen: Observation,
    ) -> list[KnownPerson]:
        """Tentative people at boxes that belong to no known person.

        A box that shows a part of a known person initiates nobody. unboxed: people that only the foreground
        shows.
        """
        least = self.params.minimum_score + EVIDENCE * seen.still
        new = self.assignment.unclaimed(seen.boxes, pairs, self.bodies.boxes(unboxed), least)
        here = [p for p in kept if p.number and not (p.absent or p.left)]
        part = self.bodies.parts(seen.boxes.box, here)
        covered, score = self.bodies.boxes(kept), seen.boxes.score
        found = [
            self.update.initiated(seen.detections[i], float(score[i]), covered, seen)
            for i in new
            if not part[i]
        ]
        return [person for person in found if person is not None]

    def state(self) -> Any:
        people = [person for person in self.people if person.number]
        told = {"people": people, "numbers": self.numbers, "illumination": self.illumination}
        return to_plain({**told, "time": self.time})

    def restore(self, state: Any) -> None:
        self.people = from_plain(list[KnownPerson], state["people"])
        self.numbers, self.time = int(state["numbers"]), int(state["time"])
        self.illumination = from_plain(Illumination, state["illumination"])

    def people_here(self) -> Array:
        """Boxes of the upper bodies of confirmed people that differ from the background, (K, 4) px."""
        return self.bodies.boxes(
            [p for p in self.people if not p.absent and p.number and (p.foreground or 0.0) >= THERE]
        )

"""Stage `persons.pose_net`: joints of people in a picture, by a network of the user's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import cv2
import numpy as np

from followspot import Array, Field, InputPath, Mistake, Room, Stage, StageParams
from followspot.errors import InputError
from followspot.people import Boxes
from followspot.points import Points2D
from followspot.room import Member
from followspot.tracking import Frame
from followspot_persons.panorama import turn_of
from followspot_persons.pose_net.blazepose import BlazePose
from followspot_persons.pose_net.contract import Decoders, People
from followspot_persons.pose_net.duplicates import distinct
from followspot_persons.pose_net.loading import decoder_named, network
from followspot_persons.pose_net.messages import boxes_of, points_of
from followspot_persons.pose_net.movenet import MoveNetMultiPose
from followspot_persons.pose_net.regions import Region, about, whole


@dataclass(frozen=True)
class Outputs:
    """Joints, one instance for each person, and the upper bodies that they make up."""

    points: Points2D
    boxes: Boxes


class PoseNet(Stage):
    """Find people and their joints by a pose network, whose model is a file of the user's.

    `points` are joints for `persons.associate` and `vision.triangulate`; `boxes` are upper bodies for the
    stages of persons, in place of `persons.hog`. A decoder for one person (`blazepose`) takes the boxes of
    another detector as its input `boxes`. Cameras of one worker share the loaded model.
    """

    per_camera = True
    decoders: ClassVar[Decoders] = {"movenet_multipose": MoveNetMultiPose, "blazepose": BlazePose}
    """By name; a subclass in another package adds its own."""

    class Params(StageParams):
        """The model and what counts as a person."""

        model: InputPath = Field(
            description="the network: a file .onnx (pip install 'followspot[posenet]') or .tflite"
        )
        decoder: str = Field(
            "movenet_multipose",
            description="what the model gives: movenet_multipose finds people in the whole picture, "
            "blazepose the joints of each person that the input boxes has",
        )
        input_side: int = Field(
            256,
            ge=64,
            le=2048,
            unit="px",
            description="shorter side of the picture in the network; raising it finds smaller people, may "
            "lose large ones and costs time; without effect if the model takes one size only",
        )
        minimum_score: float | None = Field(
            None,
            ge=0,
            lt=1,
            unit="1",
            description="smallest score of a person, by default that of the decoder; raising it finds fewer "
            "people, and fewer false ones",
        )
        minimum_joint_score: float = Field(
            0.2, ge=0, le=1, unit="1", description="smallest score of a joint; raising it avoids mistakes"
        )
        maximum_similarity: float = Field(
            0.5,
            gt=0,
            le=1,
            unit="1",
            description="object keypoint similarity beyond which two detections are one person; raising it "
            "separates people who stand close together",
        )
        frame_interval: int = Field(
            1, ge=1, unit="frames", description="one frame in so many is searched; raising it saves time"
        )

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Load the model once. Raises InputError if the decoder does not understand it."""
        if member is None or member.name == next(iter(room.cameras), ""):
            network(params.model, decoder_named(params.decoder, cls.decoders))
        return ()

    def setup(self) -> None:
        """Load the model, or share it. Raises InputError if the decoder does not understand it."""
        decoder = decoder_named(self.params.decoder, self.decoders)
        receives = self.context.receives
        if decoder.per_box and receives and Boxes not in receives:
            text = f"decoder {self.params.decoder} needs boxes of people"
            raise InputError([Mistake(None, text, "in: {boxes: DETECTOR}, for example persons.hog")])
        self.network = network(self.params.model, decoder)
        given = self.params.minimum_score
        self.minimum_score = decoder.minimum_score if given is None else given
        self.turn = turn_of(self.camera)

    def process(self, frame: Frame, boxes: Boxes | None = None) -> Outputs | None:
        return self.process_together([self], [(frame, boxes)])[0]

    @classmethod
    def process_together(
        cls, stages: Sequence[Self], inputs: Sequence[tuple[Frame, Boxes | None]]
    ) -> list[Outputs | None]:
        interval = stages[0].params.frame_interval
        taken = [max(frame.header.seq, 0) % interval == 0 for frame, _ in inputs]
        parts = [
            stage.regions(frame, boxes) if take else []
            for stage, take, (frame, boxes) in zip(stages, taken, inputs, strict=True)
        ]
        images = [image for regions in parts for _, image in regions]
        found = iter(stages[0].network.people(images))
        people = [[(region, next(found)) for region, _ in regions] for regions in parts]
        return [
            stage.outputs(seen) if take else None
            for stage, take, seen in zip(stages, taken, people, strict=True)
        ]

    def regions(self, frame: Frame, boxes: Boxes | None) -> list[tuple[Region, Array]]:
        """What the network is to see of a picture, with the images. A panorama goes on beyond its seam."""
        conversion = cv2.COLOR_GRAY2RGB if frame.pixels.shape[2] == 1 else cv2.COLOR_BGR2RGB
        pixels = np.asarray(cv2.cvtColor(frame.pixels, conversion))
        height, width = pixels.shape[:2]
        size, decoder = self.network.size, self.network.decoder
        if decoder.per_box:
            margin = min(width, 2 * height) if self.turn else 0
            known = boxes.box if boxes is not None else np.zeros((0, 4))
            found = [about(box, (width, height), size or (256, 256)) for box in known]
            regions = [region for region in found if region is not None]
            pixels = np.asarray(cv2.copyMakeBorder(pixels, 0, 0, margin, margin, cv2.BORDER_WRAP))
            return [(region, region.moved(margin).cut(pixels)) for region in regions]
        if self.turn:
            pixels = np.asarray(cv2.copyMakeBorder(pixels, 0, 0, 0, min(width, height), cv2.BORDER_WRAP))
        region = whole(pixels.shape[1], height, self.params.input_side, decoder.multiple, size)
        return [(region, region.cut(pixels))]

    def outputs(self, seen: Sequence[tuple[Region, People]]) -> Outputs:
        """The people of all regions of a picture, each once."""
        joints = self.network.decoder.joints
        pixel = [region.in_picture(people.pixel) for region, people in seen]
        all_people = People(
            np.concatenate([np.zeros((0, len(joints), 2)), *pixel]),
            np.concatenate([np.zeros((0, len(joints))), *(people.certainty for _, people in seen)]),
            np.concatenate([np.zeros(0), *(people.score for _, people in seen)]),
        )
        p = self.params
        people = all_people.where(np.flatnonzero(all_people.score >= self.minimum_score))
        rows = distinct(people, p.minimum_joint_score, p.maximum_similarity, self.turn)
        people = people.where(rows)
        points = points_of(people, joints, self.camera, p.minimum_joint_score, self.turn)
        boxes = boxes_of(
            people, joints, self.camera.name, p.minimum_joint_score, self.minimum_score, self.turn
        )
        return Outputs(points, boxes)

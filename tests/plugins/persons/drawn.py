"""Pictures of bodies of the shape model, so that trackers can be tested without recordings."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from followspot import Array, Camera, Stage
from followspot.context import Context
from followspot.geometry import project
from followspot.messages import Header, stamped
from followspot.people import Boxes, Gradients
from followspot.tracking import Frame
from followspot_persons.body.shape import ShapeModel, read_shape, with_girth
from followspot_persons.body.view import view
from followspot_persons.gradients import FindGradients
from followspot_persons.likelihood.fitness import Detection, Picture, pictured
from followspot_persons.likelihood.occlusion import silhouette

FACING = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
Color = tuple[int, int, int]
SECOND = 1_000_000_000
WALL, SKIN, HAIR = (200, 205, 210), (140, 170, 220), (30, 40, 60)
SHIRT, BACK = (160, 60, 40), (40, 60, 160)
RED, BLUE, BLACK = (40, 40, 180), (170, 70, 30), (30, 30, 30)
DIRECTIONS = np.arange(16) * (2 * np.pi / 16)


def perspective(name: str = "c") -> Camera:
    """A level camera 1.2 m above the origin that looks along x."""
    matrix = np.array([[228.5, 0, 159.5], [0, 228.5, 119.5], [0, 0, 1]])
    return Camera(name, "color", (320, 240), matrix, np.zeros(5), FACING, -FACING @ [0, 0, 1.2])


def standing(x: float, y: float = 0.0, height: float = 1.7, heading: float = np.pi) -> Array:
    """A pose (6,); heading pi faces the camera."""
    return np.array([x, y, height, heading, 0.0, 0.0])


def clothes(shape: ShapeModel, front: Color, back: Color) -> Array:
    """Colours of the surface features, (F, 3) BGR: skin, hair, and a shirt of one colour or two."""
    forward, up = shape.surface.outward[:, 0], shape.surface.position[:, 2]
    colors = np.where((forward > 0)[:, None], front, back)
    colors[shape.surface.head] = np.where((forward > 0)[:, None], SKIN, HAIR)[shape.surface.head]
    colors[up > 0.96] = HAIR
    return colors


def drawn(
    camera: Camera,
    *poses: Array,
    front: Color = SHIRT,
    back: Color = BACK,
    girth: float = 1.0,
    grounded: bool = False,
) -> Array:
    """A picture of bodies before a wall, (H, W, 3) u1; the nearest pose comes last.

    grounded: whether legs end on the floor, not at the picture's lower border.
    """
    return _drawn(camera.size, tuple(map(tuple, poses)), front, back, girth, grounded).copy()


@cache
def _drawn(
    size: tuple[int, int],
    poses: tuple[tuple[float, ...], ...],
    front: Color,
    back: Color,
    girth: float,
    grounded: bool,
) -> Array:
    camera, shape = perspective(), with_girth(read_shape(), girth)
    colors = clothes(shape, front, back)
    pixels = np.full((size[1], size[0], 3), WALL, np.uint8)
    for pose in poses:
        seen = view(camera, shape, np.array([pose]))
        foot = float(project(camera, np.array([[*pose[:2], 0.0]]))[0, 1]) if grounded else np.inf
        outline = np.rint(silhouette(shape, seen.edge[0], min(foot, float(size[1])))).astype(np.int32)
        mask = np.zeros(pixels.shape[:2], np.uint8)
        cv2.fillPoly(mask, [outline], 1)
        row, column = np.nonzero(mask)
        shown = seen.visibility[0] > 0
        place = seen.surface[0][shown]
        near = np.hypot(column[:, None] - place[:, 0], row[:, None] - place[:, 1]).argmin(axis=1)
        pixels[row, column] = colors[shown][near]
    return np.asarray(cv2.blur(pixels, (3, 3)))


def frame_of(camera: Camera, pixels: Array, time: float = 0.0, number: int = 0) -> Frame:
    """A frame with its header. time: s."""
    return stamped(Frame(camera=camera.name, pixels=pixels), Header(camera.name, number, int(time * SECOND)))


def ready(stage: type[Stage], camera: Camera, **params: object) -> Stage:
    """A stage of this camera, set up."""
    made = stage(Context.serving(camera), **params)
    made.setup()
    return made


def gradients_of(camera: Camera, frame: Frame) -> Gradients:
    """Its edges as `persons.gradients` finds them."""
    return stamped(ready(FindGradients, camera).process(frame), frame.header)


def picture_of(camera: Camera, pixels: Array) -> Picture:
    """The picture as trackers see it."""
    frame = frame_of(camera, pixels)
    return pictured(camera, frame, gradients_of(camera, frame))


def detection_of(camera: Camera, pose: Array, sureness: float = 4.0) -> Detection:
    """What a perfect detector says of a body: its box and headings."""
    seen = view(camera, read_shape(), pose[None])
    torso = sureness * np.cos(DIRECTIONS - seen.bearing.torso[0])
    head = sureness * np.cos(DIRECTIONS - seen.bearing.head[0])
    return Detection(seen.box[0], torso, head)


def boxes_of(camera: Camera, frame: Frame, *poses: Array, score: float = 2.0) -> Boxes:
    """The same as a message."""
    found = [detection_of(camera, pose) for pose in poses]
    message = Boxes(
        camera=camera.name,
        box=np.array([d.box for d in found]).reshape(-1, 4),
        score=np.full(len(found), score),
        torso=np.array([d.torso for d in found]).reshape(-1, 16),
        head=np.array([d.head for d in found]).reshape(-1, 16),
    )
    return stamped(message, frame.header)


def in_red_and_blue(camera, red, blue):
    """A picture of two people in other clothes."""
    pixels, first = drawn(camera, blue, front=BLUE, back=BLUE), drawn(camera, red, front=RED, back=RED)
    shown = np.abs(first.astype(int) - WALL).sum(axis=-1) > 30
    pixels[shown] = first[shown]
    return pixels

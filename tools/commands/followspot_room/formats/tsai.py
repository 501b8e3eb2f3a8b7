"""Tsai's camera model in XML, as data sets of surveillance have it (PETS 2009): one file for each camera.

Tsai 1987: undistorted sensor coordinates are (1 + kappa1 r^2) times the distorted ones, mm; x to the right, y
down, z forward; R = Rz Ry Rx turns the room into the camera.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET  # documents with a DOCTYPE are refused
from collections.abc import Sequence

import numpy as np

from followspot.messages import Array
from followspot.room import Camera
from followspot_room.checks import Unfit, array, camera_matrix, name, side, unique
from followspot_room.format import Calibration, Format, Texts
from followspot_room.lens_fit import simplified

GEOMETRY = ("width", "height", "dpx", "dpy")
INTRINSIC = ("focal", "kappa1", "cx", "cy", "sx")
EXTRINSIC = ("tx", "ty", "tz", "rx", "ry", "rz")
MILLIMETRES = 1000.0


def parse(files: Texts) -> Calibration | None:
    """XML files with root <Camera> and <Geometry>, <Intrinsic> and <Extrinsic>. Raises Unfit."""
    ours = {file: text for file, text in files.items() if "<Camera" in text and "kappa1" in text}
    if not ours:
        return None
    found = [_camera(file, text) for file, text in ours.items()]
    return Calibration(unique([c for c, _ in found]), notes=tuple(note for _, note in found if note))


def _camera(file: str, text: str) -> tuple[Camera, str]:
    """The camera of a file, and a note on its lens. Raises Unfit."""
    root = _root(file, text)
    geometry, lens, pose = (
        _numbers(root, part, keys, file)
        for part, keys in (("Geometry", GEOMETRY), ("Intrinsic", INTRINSIC), ("Extrinsic", EXTRINSIC))
    )
    width, height, dpx, dpy = geometry
    focal, kappa, cx, cy, sx = lens
    if not (dpx > 0 and dpy > 0 and focal > 0 and sx > 0):
        raise Unfit(f"{file}: dpx, dpy, focal and sx must be positive")
    matrix = camera_matrix([[focal * sx / dpx, 0, cx], [0, focal / dpy, cy], [0, 0, 1]], file)
    size = side(width, f"{file}: width"), side(height, f"{file}: height")
    called = name(file.rpartition(".")[0] or file, file)
    R = _rotation(pose[3:])
    camera = Camera(called, "color", size, matrix, np.zeros(5), R, pose[:3] / MILLIMETRES)
    if kappa == 0:
        return camera, ""

    def directions(pixel: Array) -> Array:
        distorted = (pixel - [cx, cy]) * [dpx / sx, dpy]
        r2 = np.square(distorted).sum(axis=1, keepdims=True)
        return np.column_stack([distorted * (1 + kappa * r2), np.full(len(pixel), focal)])

    return simplified(camera, directions, "lens by Tsai")


def _rotation(angles: Array) -> Array:
    """R = Rz Ry Rx; angles: about x, y and z, rad."""
    (a, b, c), (s, t, u) = np.cos(angles), np.sin(angles)
    x = np.array([[1, 0, 0], [0, a, -s], [0, s, a]])
    y = np.array([[b, 0, t], [0, 1, 0], [-t, 0, b]])
    z = np.array([[c, -u, 0], [u, c, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def _root(file: str, text: str) -> ET.Element:
    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise Unfit(f"{file} has a DOCTYPE", "remove it: a calibration needs none")
    try:
        return ET.fromstring(text)  # noqa: S314
    except ET.ParseError as error:
        raise Unfit(f"{file} is no XML: {error}", "copy it again") from None


def _numbers(root: ET.Element, part: str, keys: Sequence[str], file: str) -> Array:
    """Attributes of an element. Raises Unfit."""
    element = root.find(part)
    missing = [key for key in keys if element is None or key not in element.attrib]
    if element is None or missing:
        raise Unfit(f"{file}: <{part}> lacks {', '.join(missing)}", f"it needs {', '.join(keys)}")
    return array([element.attrib[key] for key in keys], (len(keys),), f"{file}: <{part}>")


FORMAT = Format("tsai", "Tsai's model in XML: <Camera> with Geometry, Intrinsic (kappa1), Extrinsic", parse)

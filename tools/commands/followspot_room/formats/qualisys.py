"""Qualisys calibrations, Calib.qca.txt: XML with cameras as Qualisys Track Manager writes them.

Positions are in mm, image measures in 1/64 px, the camera looks along its own -z with y up, and r11...r33
turn the room into the camera (as Pose2Sim reads them). Distortion coefficients are OpenCV's, of normalised
coordinates: Pose2Sim divides them by 64, which contradicts chessboards of the same cameras.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET  # documents with a DOCTYPE are refused
from collections.abc import Sequence

import numpy as np

from followspot.messages import Array
from followspot.room import Camera
from followspot_room.checks import Unfit, array, camera_matrix, holds, name, rotation, side, unique
from followspot_room.format import Calibration, Format, Texts, only_text
from followspot_room.formats.view import turned_clockwise

SUBPIXELS = 64
MILLIMETRES = 1000.0
FLIP = np.diag([1.0, -1.0, -1.0])
"""Axes from x right, y up, z back to x right, y down, z forward."""
ROTATION = tuple(f"r{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3))
FOCAL = ("focalLengthU", "focalLengthV")
CENTER = ("centerPointU", "centerPointV")
LENS = (
    "radialDistortion1",
    "radialDistortion2",
    "tangentalDistortion1",
    "tangentalDistortion2",
    "radialDistortion3",
)


def parse(files: Texts) -> Calibration | None:
    """XML with root <calibration> and <cameras>; inactive cameras are left out."""
    found = only_text(files)
    if found is None or "<calibration" not in found[1]:
        return None
    root = _root(found[1])
    listed = root.findall("cameras/camera")
    if not listed:
        return None
    active = [one for one in listed if one.get("active", "1") != "0"]
    return Calibration(unique([_camera(one, f"camera {number}") for number, one in enumerate(active, 1)]))


def write(cameras: Sequence[Camera]) -> Texts:
    """One file of XML. Raises Unfit for a lens that it cannot hold."""
    holds(cameras, ("pinhole",), "Qualisys")
    root = ET.Element("calibration", {"type": "regular", "source": "followspot"})
    ET.SubElement(root, "results", {"std-dev": "0", "min-max-diff": "0"})
    parent = ET.SubElement(root, "cameras")
    for camera in cameras:
        _add(parent, camera)
    ET.indent(root, " ")
    return {"Calib.qca.txt": ET.tostring(root, encoding="unicode", xml_declaration=False) + "\n"}


def _root(text: str) -> ET.Element:
    """The document; a DOCTYPE could expand a short file without end. Raises Unfit."""
    if re.search(r"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        raise Unfit(
            "the XML has a DOCTYPE, which no Qualisys calibration has", "export the file from QTM again"
        )
    try:
        return ET.fromstring(text)  # noqa: S314  nothing can expand
    except ET.ParseError as error:
        raise Unfit(f"this is no XML: {error}", "export the file from QTM again") from None


def _camera(one: ET.Element, where: str) -> Camera:
    called = name(one.get("serial"), where)
    where = f"camera {called}"
    video = any(word in one.get("model", "none").lower() for word in ("video", "none"))
    kind: str = "color" if video else "infrared"
    left, top, right, bottom = _field(one, "fov_video" if video else "fov_marker", where)
    lens = _child(one, "intrinsic", where)
    fx, fy = _numbers(lens, FOCAL, where) / SUBPIXELS
    cx, cy = _numbers(lens, CENTER, where) / SUBPIXELS - [left, top]
    R = FLIP @ rotation(_numbers(_child(one, "transform", where), ROTATION, where).reshape(3, 3), where)
    center = _numbers(_child(one, "transform", where), ("x", "y", "z"), where) / MILLIMETRES
    camera = Camera(
        name=called,
        kind=kind,
        size=(side(right - left + 1, f"{where}: width"), side(bottom - top + 1, f"{where}: height")),
        matrix=camera_matrix([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], f"{where}: intrinsic"),
        distortion=_numbers(lens, LENS, where),
        rotation=R,
        translation=-R @ center,
    )
    return turned_clockwise(camera, _quarters(one, where))


def _quarters(one: ET.Element, where: str) -> int:
    """Quarter turns by which the video is shown clockwise. Raises Unfit."""
    text = one.get("viewrotation", "0")
    if text not in ("0", "90", "180", "270"):
        raise Unfit(f"{where}: viewrotation is {text!r}", "write 0, 90, 180 or 270")
    return int(text) // 90


def _field(one: ET.Element, tag: str, where: str) -> list[int]:
    """left, top, right, bottom of the picture on the sensor, px, both ends included."""
    values = _numbers(_child(one, tag, where), ("left", "top", "right", "bottom"), f"{where}: {tag}")
    if (values % 1 != 0).any():
        raise Unfit(f"{where}: {tag} is not in whole pixels")
    return [int(value) for value in values]


def _child(one: ET.Element, tag: str, where: str) -> ET.Element:
    found = one.find(tag)
    if found is None:
        raise Unfit(f"{where} has no <{tag}>", "export the file from QTM again")
    return found


def _numbers(one: ET.Element, keys: Sequence[str], where: str) -> Array:
    missing = [key for key in keys if one.get(key) is None]
    if missing:
        raise Unfit(f"{where}: <{one.tag}> has no {missing[0]}", "export the file from QTM again")
    return array([one.get(key) for key in keys], (len(keys),), f"{where}: <{one.tag}>")


def _add(parent: ET.Element, camera: Camera) -> None:
    """The camera as an element; a marker camera is infrared."""
    if camera.matrix[0, 1] != 0:
        raise Unfit(f"camera {camera.name} has a skewed matrix, which Qualisys cannot hold", "set it to 0")
    width, height = camera.size
    model = "none" if camera.kind == "color" else "Marker"
    one = ET.SubElement(
        parent, "camera", {"active": "1", "serial": camera.name, "model": model, "viewrotation": "0"}
    )
    edges = {"left": "0", "top": "0", "right": str(width - 1), "bottom": str(height - 1)}
    for tag in ("fov_marker", "fov_marker_max", "fov_video", "fov_video_max"):
        ET.SubElement(one, tag, edges)
    pose = [*(camera.center * MILLIMETRES), *(FLIP @ camera.rotation).ravel()]
    ET.SubElement(one, "transform", _texts(("x", "y", "z", *ROTATION), pose))
    K = camera.matrix * SUBPIXELS
    limits = {"sensorMinU": "0", "sensorMaxU": str(width * SUBPIXELS)}
    limits |= {"sensorMinV": "0", "sensorMaxV": str(height * SUBPIXELS), "skew": "0"}
    values = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], *camera.distortion]
    ET.SubElement(one, "intrinsic", {**limits, **_texts((*FOCAL, *CENTER, *LENS), values)})


def _texts(keys: Sequence[str], values: Sequence[float]) -> dict[str, str]:
    return {key: repr(float(value)) for key, value in zip(keys, values, strict=True)}


FORMAT = Format("qualisys", "Qualisys Calib.qca.txt (XML)", parse, write, infrared=True)

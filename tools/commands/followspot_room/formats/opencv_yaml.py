"""OpenCV's YAML (cv2.FileStorage): camera_matrix, distortion_coefficients and the size of the picture.

A file may hold one camera, as OpenCV's calibration sample and ROS camera_info do, or one mapping per camera;
a folder may hold a file for each. Read without OpenCV, with the limits and places of any other YAML.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from followspot.errors import InputError
from followspot.room import Camera, LensModel
from followspot.yaml.node import plain
from followspot.yaml.reader import parse as parse_yaml
from followspot_room.checks import (
    Unfit,
    array,
    camera_matrix,
    holds,
    lens,
    name,
    rotation_or_vector,
    side,
    unique,
)
from followspot_room.format import Calibration, Format, Texts

SUFFIXES = (".yml", ".yaml")
HEADER = re.compile(r"\A%YAML[: ][^\n]*")
TAG = "!!opencv-matrix"
MATRIX = ("camera_matrix", "Camera_Matrix", "K")
LENS = ("distortion_coefficients", "Distortion_Coefficients", "dist_coeffs", "D")
TURN = ("R", "rotation_matrix", "rvec")
SHIFT = ("T", "t", "translation_vector", "tvec")
FISHEYE = ("equidistant", "fisheye")
Mapped = Mapping[str, Any]


def parse(files: Texts) -> Calibration | None:
    """Cameras of all files; each has a camera matrix. Raises Unfit."""
    found: list[Camera] = []
    for file, text in files.items():
        document = _document(text, file) if file.endswith(SUFFIXES) else {}
        if _key(document, MATRIX):
            found.append(_camera(document, str(document.get("camera_name") or file.rpartition(".")[0])))
        else:
            found += [_camera(one, key) for key, one in document.items() if _key(one, MATRIX)]
    return Calibration(unique(found)) if found else None


def write(cameras: Sequence[Camera]) -> Texts:
    """One file with a mapping per camera, which cv2.FileStorage reads. Raises Unfit."""
    holds(cameras, ("pinhole", "rational", "fisheye"), "OpenCV")
    return {"cameras.yml": "%YAML:1.0\n---\n" + "".join(map(_written, cameras))}


def _document(text: str, file: str) -> Mapped:
    """The mapping of a file; the header and the tags of OpenCV are none that YAML knows. Raises Unfit."""
    known = HEADER.sub("", text).replace(TAG, " " * len(TAG))
    try:
        document = plain(parse_yaml(known, file, text))
    except InputError as error:
        first = error.mistakes[0]
        line = f", line {first.place.line}" if first.place else ""
        raise Unfit(f"{file}{line}: {first.text}", first.remedy) from None
    return document if isinstance(document, dict) else {}


def _camera(one: Mapped, called: str) -> Camera:
    called = name(called, called)
    where = f"camera {called}"
    width, height = _size(one, where)
    model: LensModel = "pinhole"
    if one.get("fisheye_model") in (1, True) or one.get("distortion_model") in FISHEYE:
        model = "fisheye"
    bent, turn, shift = (_key(one, keys) for keys in (LENS, TURN, SHIFT))
    flat = [] if bent is None else _flat(one[bent], f"{where}: {bent}")
    model, coefficients = lens(flat, model, f"{where}: {bent}")
    return Camera(
        name=called,
        kind="color",
        size=(width, height),
        matrix=camera_matrix(_rows(one[str(_key(one, MATRIX))], f"{where}: camera_matrix"), where),
        distortion=coefficients,
        rotation=rotation_or_vector(_rows(one[turn], where) if turn else [0, 0, 0], f"{where}: {turn}"),
        translation=array(_flat(one[shift], where) if shift else [0, 0, 0], (3,), f"{where}: {shift}"),
        model=model,
    )


def _size(one: Mapped, where: str) -> tuple[int, int]:
    found = (one.get("image_width"), one.get("image_height"))
    if None in found:
        raise Unfit(f"{where} has no size", "add image_width and image_height, px")
    return side(found[0], f"{where}: image_width"), side(found[1], f"{where}: image_height")


def _key(one: Any, names: Sequence[str]) -> str | None:
    """The name under which the mapping has a value; None if it has none."""
    return next((key for key in names if key in one), None) if isinstance(one, dict) else None


def _flat(value: Any, where: str) -> list[Any]:
    """The numbers of an OpenCV matrix, or of a list. Raises Unfit."""
    data = value.get("data") if isinstance(value, dict) else value
    if not isinstance(data, list):
        raise Unfit(f"{where} is no matrix", "write rows, cols, dt and data as OpenCV does")
    return [item for row in data for item in (row if isinstance(row, list) else [row])]


def _rows(value: Any, where: str) -> list[Any]:
    """Nine numbers as three rows, three as they are. Raises Unfit."""
    flat = _flat(value, where)
    return [flat[i : i + 3] for i in range(0, len(flat), 3)] if len(flat) != 3 else flat


def _written(camera: Camera) -> str:
    matrices = {
        "camera_matrix": camera.matrix,
        "distortion_coefficients": camera.distortion.reshape(1, -1),
        "R": camera.rotation,
        "T": camera.translation.reshape(3, 1),
    }
    lines = [
        f"{camera.name}:",
        f"   image_width: {camera.size[0]}",
        f"   image_height: {camera.size[1]}",
        f"   fisheye_model: {int(camera.model == 'fisheye')}",
    ]
    for key, values in matrices.items():
        rows, columns = values.shape
        lines += [f"   {key}: {TAG}", f"      rows: {rows}", f"      cols: {columns}", "      dt: d"]
        lines.append(f"      data: [ {', '.join(map(_number, values.ravel().tolist()))} ]")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """A number as readers of YAML 1.1 and OpenCV take it, with every bit."""
    text = repr(value)
    return text if "." in text else text.replace("e", ".0e")


FORMAT = Format(
    "opencv", "OpenCV YAML with camera_matrix and image_width (a file, or a folder of files)", parse, write
)

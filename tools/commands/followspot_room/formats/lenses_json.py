"""Lenses in JSON: cameras by name, or one camera, with a matrix, its distortion and the size of the picture.

So write multiview_calib (intrinsics.json) and most scripts around OpenCV. R and t may be there as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from followspot.room import Camera
from followspot_room.checks import Unfit, name, side, unique
from followspot_room.format import Calibration, Format, Texts, only_text
from followspot_room.formats.opencv_json import json_object, pinhole

MATRIX = ("K", "camera_matrix", "mtx", "intrinsic_matrix", "cameraMatrix")
LENS = ("dist", "dist_coeff", "dist_coeffs", "distortion", "distortion_coefficients", "distCoeffs", "D")
SIDES = (("width", "height"), ("image_width", "image_height"))
POSE = ("R", "t")


def parse(files: Texts) -> Calibration | None:
    """JSON of one camera, or whose entries all are cameras. Raises Unfit."""
    document = json_object(files)
    found = only_text(files)
    if found is not None and _key(document, MATRIX):
        return Calibration((_camera(document, found[0].rpartition(".")[0] or found[0]),))
    if not document or not all(_key(one, MATRIX) for one in document.values()):
        return None
    return Calibration(unique([_camera(one, called) for called, one in document.items()]))


def _camera(one: Mapping[str, Any], called: str) -> Camera:
    """A camera; without R and t it stands at the origin. Raises Unfit."""
    where = f"camera {name(called, 'a camera')}"
    width, height = _size(one, where)
    lens = _key(one, LENS)
    flat = [] if lens is None else _flat(one[lens])
    known = {"K": one[str(_key(one, MATRIX))], "dist": flat, "width": width, "height": height}
    return pinhole(known | {key: one[key] for key in POSE if key in one}, called)


def _size(one: Mapping[str, Any], where: str) -> tuple[int, int]:
    """Width and height; image_size is given so, image_shape the other way round. Raises Unfit."""
    for across, down in SIDES:
        if across in one and down in one:
            return side(one[across], f"{where}: {across}"), side(one[down], f"{where}: {down}")
    for key, order in (("image_size", (0, 1)), ("image_shape", (1, 0))):
        both = one.get(key)
        if isinstance(both, list) and len(both) >= 2:
            first, second = (both[k] for k in order)
            return side(first, f"{where}: {key}"), side(second, f"{where}: {key}")
    raise Unfit(f"{where} has no size of its pictures", 'add "width" and "height", px')


def _flat(value: Any) -> Any:
    """The coefficients of [[k1, k2, ...]] or [[k1], [k2], ...], as numpy has them; others as they are."""
    if isinstance(value, list) and value and all(isinstance(row, list) for row in value):
        return [number for row in value for number in row]
    return value


def _key(one: Any, names: Sequence[str]) -> str | None:
    return next((key for key in names if key in one), None) if isinstance(one, dict) else None


FORMAT = Format(
    "lenses-json", 'JSON of cameras by name, or of one, with "K", "dist", "width", "height"', parse
)

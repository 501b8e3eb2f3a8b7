"""Cameras as tables of TOML, after aniposelib: size, matrix, distortions, rotation, translation (m)."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.room import Camera, LensModel
from followspot_room.checks import (
    Unfit,
    array,
    camera_matrix,
    lens,
    name,
    rotation_or_vector,
    side,
)
from followspot_room.format import Texts, only_text

Table = Mapping[str, Any]


def toml_tables(files: Texts) -> dict[str, Table] | None:
    """The tables of a TOML file; None if it is none. Raises Unfit for a .toml that cannot be read."""
    found = only_text(files)
    if found is None:
        return None
    try:
        document = tomllib.loads(found[1])
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        if found[0].endswith(".toml"):
            raise Unfit(
                f"this is no TOML: {error}", "mend the line, or export the calibration again"
            ) from None
        return None
    return {key: value for key, value in document.items() if isinstance(value, dict)}


def is_camera(table: Any) -> bool:
    """True if a table holds a calibrated camera."""
    return isinstance(table, dict) and {"matrix", "size"} <= table.keys()


def camera_of(table: Table, called: str) -> Camera:
    """The camera of a table; without rotation and translation it stands at the origin. Raises Unfit.

    rotation is a Rodrigues vector (rad), in older files a matrix.
    """
    called = name(table.get("name", called), called)
    where = f"camera {called}"
    size = table["size"]
    if not isinstance(size, list) or len(size) != 2:
        raise Unfit(f"{where}: size is {size!r}, needs width and height", "write size = [1280, 720]")
    model: LensModel = "fisheye" if table.get("fisheye") is True else "pinhole"
    model, coefficients = lens(table.get("distortions", []), model, f"{where}: distortions")
    return Camera(
        name=called,
        kind="color",
        size=(side(size[0], f"{where}: width"), side(size[1], f"{where}: height")),
        matrix=camera_matrix(table["matrix"], f"{where}: matrix"),
        distortion=coefficients,
        rotation=rotation_or_vector(table.get("rotation", [0, 0, 0]), f"{where}: rotation"),
        translation=_translation(table.get("translation", [0, 0, 0]), f"{where}: translation"),
        model=model,
    )


def table_of(camera: Camera) -> Table:
    """The camera as a table."""
    return {
        "name": camera.name,
        "size": list(camera.size),
        "matrix": camera.matrix.tolist(),
        "distortions": camera.distortion.tolist(),
        "rotation": rotation_vector(camera.rotation).tolist(),
        "translation": camera.translation.tolist(),
        "fisheye": camera.model == "fisheye",
    }


def rotation_vector(R: Array) -> Array:
    """Axis times angle of a rotation matrix, (3,) rad, exact for any angle.

    By the quaternion that fits best (Bar-Itzhack 2000); cv2.Rodrigues takes angles below 1e-5 for none.
    """
    trace = np.trace(R)
    K = np.empty((4, 4))
    K[:3, :3] = R + R.T - trace * np.eye(3)
    K[3, :3] = K[:3, 3] = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    K[3, 3] = trace
    q = np.linalg.eigh(K)[1][:, 3]
    q = q if q[3] >= 0 else -q
    sine = np.linalg.norm(q[:3])
    return np.asarray(q[:3] * (2 * np.arctan2(sine, q[3]) / sine if sine > 0 else 2.0))


def toml_text(tables: Mapping[str, Table]) -> str:
    """Tables of numbers, texts and lists as TOML; such values are written as in JSON."""
    return "\n".join(_section(title, table) for title, table in tables.items())


def _section(title: str, table: Table) -> str:
    lines = [f"{key} = {json.dumps(value)}\n" for key, value in table.items()]
    return f"[{title}]\n{''.join(lines)}"


def _translation(value: Any, where: str) -> Array:
    """Three numbers, also as a column. Raises Unfit."""
    flat: Sequence[Any] = np.ravel(np.array(value, object)).tolist()
    return array(flat, (3,), where)

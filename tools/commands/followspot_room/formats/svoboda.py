"""Folders of Svoboda's MultiCamSelfCal: camera1.Pmat.cal, basename1.rad, Res.dat, camera_order.txt.

Svoboda, Martinec & Pajdla 2005: a projection matrix for each camera, and of its lens the matrix and k1, k2,
p1, p2 of the Caltech toolbox. Cameras are counted from 1; their units are those of the self-calibration.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from followspot.messages import Array
from followspot.room import Camera
from followspot_room.checks import Unfit, array, camera_matrix, distortion, holds, name, side, unique
from followspot_room.format import Calibration, Format, Texts
from followspot_room.lens_fit import simplified, undistorted

PMAT = re.compile(r"camera(\d{1,4})\.Pmat\.cal")
RAD = re.compile(r"\D*(\d{1,4})\.rad")
RESOLUTION = "Res.dat"
ORDER = "camera_order.txt"
KEYS = tuple(f"K{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3))
LENS = ("kc1", "kc2", "kc3", "kc4")
SAME = 1e-3
"""Difference of two matrices that is passed over, px."""


def parse(files: Texts) -> Calibration | None:
    """Projection matrices, lenses, or both. Raises Unfit."""
    matrices = _numbered(files, PMAT)
    lenses = _numbered(files, RAD)
    numbers = sorted({*matrices, *lenses})
    if not numbers:
        return None
    sizes = _sizes(files, numbers)
    names = _names(files, numbers)
    read = [_camera(names[n], sizes[n], matrices.get(n), lenses.get(n), n) for n in numbers]
    return Calibration(unique([camera for camera, _ in read]), notes=tuple(note for _, note in read if note))


def write(cameras: Sequence[Camera]) -> Texts:
    """A folder of files. Raises Unfit for a lens with k3, or of another model."""
    holds(cameras, ("pinhole",), "MultiCamSelfCal")
    files = {
        RESOLUTION: "".join(f"{camera.size[0]} {camera.size[1]}\n" for camera in cameras),
        ORDER: "".join(f"{camera.name}\n" for camera in cameras),
    }
    for number, camera in enumerate(cameras, 1):
        if camera.distortion[4] != 0:
            text = f"camera {camera.name} has a distortion k3, which MultiCamSelfCal cannot hold"
            raise Unfit(text, "calibrate its lens without k3, or export as anipose or opencv")
        P = camera.projection
        files[f"camera{number}.Pmat.cal"] = "".join(" ".join(map(repr, row)) + "\n" for row in P.tolist())
        K = zip(KEYS, camera.matrix.ravel().tolist(), strict=True)
        kc = zip(LENS, camera.distortion[:4].tolist(), strict=True)
        files[f"basename{number}.rad"] = "".join(f"{key} = {value!r}\n" for key, value in [*K, *kc])
    return files


def decompose(P: Array) -> tuple[Array, Array, Array]:
    """K with K33 = 1, R and t of P ~ K [R | t] (H&Z, section 6.2.4, RQ decomposition).

    P: (3, 4), of any scale and sign; M = K R with positive focal lengths and det R = 1.
    Raises numpy.linalg.LinAlgError if M is singular.
    """
    P = P * np.sign(np.linalg.det(P[:, :3]))
    Q, U = np.linalg.qr(np.linalg.inv(P[:, :3]))
    signs = np.diag(np.sign(np.diag(U)))
    K = np.linalg.inv(signs @ U)
    return K / K[2, 2], (Q @ signs).T, np.linalg.solve(K, P[:, 3])


def _camera(
    called: str, size: tuple[int, int], pmat: str | None, rad: str | None, number: int
) -> tuple[Camera, str]:
    """The camera, and a note if its two files have different matrices.

    The projection is P, whose pose and matrix were fitted last; the distortion is about the matrix of the
    .rad file, by which the pixels were straightened before P was fitted to them.
    """
    where = f"camera{number}.Pmat.cal"
    K, lens = (np.eye(3), np.zeros(5)) if rad is None else _lens(rad, f"the .rad file of camera {number}")
    if pmat is None:
        return Camera(called, "color", size, K, lens, np.eye(3), np.zeros(3)), ""
    P = array([row.split() for row in pmat.splitlines() if row.strip()], (3, 4), where)
    try:
        own, R, t = decompose(P)
    except np.linalg.LinAlgError:
        raise Unfit(f"{where} is no projection matrix: its left 3x3 part is singular") from None
    camera = Camera(called, "color", size, camera_matrix(np.triu(own), where), lens, R, t)
    if rad is None:
        return camera, ""
    if np.abs(own - K).max() < SAME:
        return replace(camera, matrix=K), ""

    def directions(pixel: Array) -> Array:
        return np.asarray(undistorted(K, lens, pixel) @ K.T @ np.linalg.inv(own).T)

    return simplified(camera, directions, f"lens, with different matrices in {where} and its .rad file,")


def _lens(text: str, where: str) -> tuple[Array, Array]:
    """Matrix and distortion of a .rad file, lines KEY = VALUE. Raises Unfit."""
    pairs = (line.split("#")[0].partition("=") for line in text.splitlines())
    values: Mapping[str, str] = {key.strip(): value.strip() for key, _, value in pairs}
    missing = [key for key in (*KEYS, *LENS) if key not in values]
    if missing:
        raise Unfit(f"{where} has no {missing[0]}", "it needs K11 ... K33 and kc1 ... kc4")
    K = array([values[key] for key in KEYS], (9,), where).reshape(3, 3)
    return camera_matrix(K, where), distortion([values[key] for key in LENS], "pinhole", where)


def _numbered(files: Texts, pattern: re.Pattern[str]) -> dict[int, str]:
    matches = ((pattern.fullmatch(file), text) for file, text in files.items())
    return {int(match[1]): text for match, text in matches if match}


def _sizes(files: Texts, numbers: Sequence[int]) -> dict[int, tuple[int, int]]:
    """Width and height, px, from the lines of Res.dat. Raises Unfit."""
    rows = [line.split() for line in files.get(RESOLUTION, "").splitlines() if line.strip()]
    if len(rows) < numbers[-1] or any(len(row) != 2 for row in rows):
        text = f"{RESOLUTION} does not have width and height of camera {numbers[-1]}"
        raise Unfit(text, f"give the folder, with one line a camera in {RESOLUTION}, for example 752 480")
    both = {n: array(rows[n - 1], (2,), f"{RESOLUTION}, line {n}").tolist() for n in numbers}
    return {n: (side(w, f"camera {n}: width"), side(h, f"camera {n}: height")) for n, (w, h) in both.items()}


def _names(files: Texts, numbers: Sequence[int]) -> dict[int, str]:
    """From camera_order.txt, else camera1, camera2, ... Raises Unfit."""
    if ORDER not in files:
        return {n: f"camera{n}" for n in numbers}
    lines = files[ORDER].split()
    if len(lines) < numbers[-1]:
        raise Unfit(f"{ORDER} has {len(lines)} names, camera {numbers[-1]} has none", "one name a line")
    return {n: name(lines[n - 1], f"{ORDER}, line {n}") for n in numbers}


FORMAT = Format(
    "svoboda",
    "folder of MultiCamSelfCal: camera1.Pmat.cal, basename1.rad, Res.dat",
    parse,
    write,
    folder=True,
)

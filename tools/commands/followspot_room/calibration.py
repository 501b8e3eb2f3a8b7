"""Calibrations in files of every known format; the content decides which."""

from __future__ import annotations

import errno
from dataclasses import replace
from pathlib import Path

from followspot.errors import InputError
from followspot.files import DATA, read_bytes
from followspot_room.checks import Unfit
from followspot_room.format import Calibration, Texts
from followspot_room.formats import (
    anipose,
    caliscope,
    lenses_json,
    opencv_json,
    opencv_yaml,
    qualisys,
    svoboda,
    tsai,
    typed_json,
)

FORMATS = (
    opencv_json.FORMAT,
    typed_json.FORMAT,
    lenses_json.FORMAT,
    caliscope.FORMAT,
    anipose.FORMAT,
    qualisys.FORMAT,
    svoboda.FORMAT,
    tsai.FORMAT,
    opencv_yaml.FORMAT,
)
"""In the order in which they are tried."""
IN_FOLDERS = ("*.rad", "*.Pmat.cal", "camera_order.txt", "Res.dat", "*.xml", "*.yml", "*.yaml")
"""Files that are read from a folder; others are ignored."""
NO_POSES = "the calibration has no camera poses: all cameras stand at the origin until you calibrate them"


def read_calibration(path: Path) -> Calibration:
    """The calibration in a file or folder of any known format. Raises InputError."""
    files = _texts(path)
    try:
        for known in FORMATS:
            calibration = known.parse(files) if files else None
            if calibration is not None:
                notes = calibration.notes if calibration.posed else (*calibration.notes, NO_POSES)
                return replace(calibration, notes=notes)
    except Unfit as mistake:
        raise InputError.of(f"{path}: {mistake}", mistake.remedy) from None
    names = "; ".join(known.name for known in FORMATS)
    raise InputError.of(f"{path} is no calibration in a known format", f"known: {names}")


def _texts(path: Path) -> Texts:
    """The texts of a file, or of the matching files of a folder; none if they are not text."""
    chosen = [path]
    if path.is_dir():
        chosen = sorted(one for pattern in IN_FOLDERS for one in path.glob(pattern) if one.is_file())
    texts: dict[str, str] = {}
    left = DATA  # bytes that all files together may still have
    try:
        for one in chosen:
            data = read_bytes(one, left)
            left -= len(data)
            texts[one.name] = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return {}
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise InputError.of(f"{path} is larger than {DATA} bytes", TOO_LARGE) from None
        text = f"{path} cannot be read: {error.strerror}"
        raise InputError.of(text, "give a calibration file or its folder") from None
    return texts


TOO_LARGE = "give the file with the calibration alone"

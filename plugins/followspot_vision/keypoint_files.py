"""Joints of persons from JSON files of OpenPose and MMPose, and in COCO's format for results: checked, with
the place of each mistake.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any

from followspot.errors import InputError, Mistake, Place
from followspot.files import DATA, DOCUMENT, read_text
from followspot_vision.picture_points import FARTHEST

MOST_PERSONS = 1000
"""In one picture."""
MOST_JOINTS = 1000
LARGEST = 2**31 - 1
_OPENPOSE = re.compile(r"(?:.*_)?(\d{1,18})_keypoints\.json")
_NUMBERED = re.compile(r"(?:.*\D)?(\d{1,18})\.json")
_DIGITS = re.compile(r"(\d{1,18})(?:\.\w+)?$")

Joint = tuple[float, float, float]
"""x, y, score."""


Person = Sequence[Joint]
"""The joints of one person; those that were not found have the score 0."""


def picture_files(folder: Path, cameras: Collection[str]) -> list[tuple[int, Path]]:
    """The files of a folder with the persons of one picture each, by the number of the picture.

    They are NAME_000000000012_keypoints.json as OpenPose writes them, or if there are none, NAME12.json
    where NAME12 is none of the room's cameras: cam1.json has the results of the camera cam1. Raises
    InputError if two have one number.
    """
    paths = sorted(folder.iterdir())
    named = [(match, path) for path in paths if (match := _OPENPOSE.fullmatch(path.name))]
    others = [path for path in paths if path.stem not in cameras]
    named = named or [(match, path) for path in others if (match := _NUMBERED.fullmatch(path.name))]
    found: dict[int, Path] = {}
    for match, path in named:
        number = int(match[1])
        if number > LARGEST:
            raise InputError.of(f"{path} has the number {number}", f"pictures are numbered up to {LARGEST}")
        if number in found:
            text = f"{found[number]} and {path} are of one picture"
            raise InputError.of(text, "give each camera a folder of its own")
        found[number] = path
    return sorted(found.items())


def read_picture(path: Path) -> list[Person]:
    """The persons of one picture, in OpenPose's format or MMPose's. Raises InputError."""
    data = _read(path, DOCUMENT)
    if isinstance(data, dict) and "instances" in data:
        data = data["instances"]
    if isinstance(data, list):
        return _instances(data, str(path))
    people = data.get("people") if isinstance(data, dict) else None
    if not isinstance(people, list):
        raise InputError.of(f"{path} has no list people", "it should be a file that OpenPose or MMPose wrote")
    _check_count(len(people), f"{path} has")
    return [
        _person(_entry(one, "pose_keypoints_2d", f"{path}: people[{i}]"), f"{path}: people[{i}]")
        for i, one in enumerate(people)
    ]


def read_results(path: Path, camera: str = "", cameras: Collection[str] = ()) -> dict[int, list[Person]]:
    """The persons of each picture, by its number, of a file about many pictures. Raises InputError.

    The file is a list in COCO's format for results, whose image_id ends in the number, or MMPose's of a
    video: a list of {frame_id, instances}. camera: whose pictures they are, of these cameras.
    """
    others = [name for name in cameras if name != camera and not name.isdigit()]
    data = _read(path, DATA)
    if isinstance(data, dict):
        data = data.get("annotations", data.get("instance_info"))
    if not isinstance(data, list):
        remedy = "it should be a list of {image_id, keypoints, score}, or a folder of OpenPose's files"
        raise InputError.of(f"{path} is no list of results", remedy)
    found: dict[int, list[Person]] = {}
    for i, one in enumerate(data):
        where = f"{path}: [{i}]"
        if isinstance(one, dict) and "instances" in one:
            number = _number(_entry(one, "frame_id", where), where, "frame_id")
            found.setdefault(number, []).extend(_instances(one["instances"], f"{where}.instances"))
        else:
            image = _entry(one, "image_id", where)
            number = _number(image, where, "image_id")
            _check_camera(image, where, camera, others)
            found.setdefault(number, []).append(_person(_entry(one, "keypoints", where), where))
        _check_count(len(found[number]), f"{where}: a picture has")
    return found


def _instances(instances: Any, where: str) -> list[Person]:
    """Persons as MMPose writes them: keypoints [[x, y], ...] and keypoint_scores. Raises InputError."""
    if not isinstance(instances, list):
        raise InputError.of(f"{where} is no list of instances")
    _check_count(len(instances), f"{where} has")
    return [_instance(one, f"{where}[{i}]") for i, one in enumerate(instances)]


def _instance(one: Any, where: str) -> Person:
    places, scores = _entry(one, "keypoints", where), _entry(one, "keypoint_scores", where)
    pairs = isinstance(places, list) and all(isinstance(xy, list) and len(xy) == 2 for xy in places)
    if not pairs or not isinstance(scores, list) or len(scores) != len(places):
        raise InputError.of(f"{where} has no keypoints [[x, y], ...] with as many keypoint_scores")
    return _person([n for xy, score in zip(places, scores, strict=True) for n in (*xy, score)], where)


def _read(path: Path, most: int) -> Any:
    try:
        return json.loads(read_text(path, most), parse_constant=_no_constant, object_pairs_hook=_mapping)
    except OSError as error:
        raise InputError.of(f"{path} cannot be read: {error.strerror}") from None
    except json.JSONDecodeError as error:
        place = Place(str(path), error.lineno, error.colno)
        raise InputError([Mistake(place, f"this is not JSON: {error.msg}")]) from None
    except UnicodeDecodeError:
        raise InputError.of(f"{path} is not JSON: it is not UTF-8", "save it as UTF-8") from None
    except (ValueError, RecursionError) as error:
        raise InputError.of(f"{path} is not JSON: {error}") from None


def _mapping(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """The entries of an object. Raises ValueError if one stands there twice: which of them counts?"""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"an object has {json.dumps(twice)[:40]} twice")
    return found


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is no number; leave out what was not found, or give it the score 0")


def _entry(one: Any, key: str, where: str) -> Any:
    if not isinstance(one, dict) or key not in one:
        raise InputError.of(f"{where} has no {key}")
    return one[key]


def _number(image: Any, where: str, key: str) -> int:
    """The number of a picture: 12, "12" or "pictures/cam0_000012.jpg"."""
    digits = _DIGITS.search(image) if isinstance(image, str) else None
    number = int(digits[1]) if digits else image
    if type(number) is not int or not 0 <= number <= LARGEST:
        raise InputError.of(f"{where}.{key} is {str(image)[:40]!r}", "it should be a number, or end in one")
    return number


def _check_camera(image: Any, where: str, camera: str, others: Sequence[str]) -> None:
    """Raise InputError if the name of a picture says that another camera took it."""
    if not isinstance(image, str) or _names(image, camera):
        return
    other = next((name for name in others if _names(image, name)), None)
    if other is not None:
        text = f"{where}.image_id is {image[:80]!r}, of camera {other}, and is read for {camera}"
        raise InputError.of(text, "write a file for each camera, CAMERA.json")


def _names(image: str, camera: str) -> bool:
    """Whether the name of a picture has that of a camera in it, as a whole."""
    return re.search(rf"(?<![A-Za-z0-9]){re.escape(camera)}(?![A-Za-z0-9])", image) is not None


def _person(values: Any, where: str) -> Person:
    """x, y, score of each joint in one list. A visibility of COCO's annotations (0, 1, 2) is a score, too."""
    if not isinstance(values, list) or len(values) % 3 or len(values) > 3 * MOST_JOINTS:
        raise InputError.of(f"{where} has no list x, y, score, x, y, score, ...")
    numbers = list(_numbers(values, where))
    return list(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True))


def _numbers(values: Sequence[Any], where: str) -> Iterator[float]:
    for i, value in enumerate(values):
        usable = type(value) in (int, float) and abs(value) <= FARTHEST and math.isfinite(value)
        if not usable:
            text = f"{where}: number {i} is {json.dumps(value)[:40]}"
            remedy = f"numbers lie within {FARTHEST:.0f}; what was not found has the score 0"
            raise InputError.of(text, remedy)
        yield float(value)


def _check_count(persons: int, text: str) -> None:
    if persons > MOST_PERSONS:
        raise InputError.of(f"{text} {persons} persons", f"at most {MOST_PERSONS} in a picture")

"""Joints of persons from JSON files of OpenPose and in COCO's format for results: checked, with the place of
each mistake.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
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
_DIGITS = re.compile(r"(\d{1,18})(?:\.\w+)?$")

Joint = tuple[float, float, float]
"""x, y, score."""


Person = Sequence[Joint]
"""The joints of one person; those that were not found have the score 0."""


def openpose_files(folder: Path) -> list[tuple[int, Path]]:
    """The files NAME_000000000012_keypoints.json of a folder, by the number of the picture.

    Raises InputError if two have one number.
    """
    found: dict[int, Path] = {}
    for path in sorted(folder.iterdir()):
        named = _OPENPOSE.fullmatch(path.name)
        if named is None:
            continue
        number = int(named[1])
        if number > LARGEST:
            raise InputError.of(f"{path} has the number {number}", f"pictures are numbered up to {LARGEST}")
        if number in found:
            text = f"{found[number]} and {path} are of one picture"
            raise InputError.of(text, "give each camera a folder of its own")
        found[number] = path
    return sorted(found.items())


def read_openpose(path: Path) -> list[Person]:
    """The persons of one picture. Raises InputError."""
    data = _read(path, DOCUMENT)
    people = data.get("people") if isinstance(data, dict) else None
    if not isinstance(people, list):
        raise InputError.of(f"{path} has no list people", "it should be a file that OpenPose wrote")
    _check_count(len(people), f"{path} has")
    return [
        _person(_entry(one, "pose_keypoints_2d", f"{path}: people[{i}]"), f"{path}: people[{i}]")
        for i, one in enumerate(people)
    ]


def read_coco(path: Path) -> dict[int, list[Person]]:
    """The persons of each picture, by its number: the last digits of image_id. Raises InputError."""
    data = _read(path, DATA)
    if isinstance(data, dict):
        data = data.get("annotations")
    if not isinstance(data, list):
        remedy = "it should be a list of {image_id, keypoints, score}, or a folder of OpenPose's files"
        raise InputError.of(f"{path} is no list of results", remedy)
    found: dict[int, list[Person]] = {}
    for i, one in enumerate(data):
        where = f"{path}: [{i}]"
        persons = found.setdefault(_number(_entry(one, "image_id", where), where), [])
        persons.append(_person(_entry(one, "keypoints", where), where))
        _check_count(len(persons), f"{where}: a picture has")
    return found


def _read(path: Path, most: int) -> Any:
    try:
        return json.loads(read_text(path, most), parse_constant=_no_constant)
    except OSError as error:
        raise InputError.of(f"{path} cannot be read: {error.strerror}") from None
    except json.JSONDecodeError as error:
        place = Place(str(path), error.lineno, error.colno)
        raise InputError([Mistake(place, f"this is not JSON: {error.msg}")]) from None
    except (ValueError, RecursionError) as error:
        raise InputError.of(f"{path} is not JSON: {error}") from None


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is no number; leave out what was not found, or give it the score 0")


def _entry(one: Any, key: str, where: str) -> Any:
    if not isinstance(one, dict) or key not in one:
        raise InputError.of(f"{where} has no {key}")
    return one[key]


def _number(image: Any, where: str) -> int:
    """The number of a picture: 12, "12" or "pictures/cam0_000012.jpg"."""
    digits = _DIGITS.search(image) if isinstance(image, str) else None
    number = int(digits[1]) if digits else image
    if type(number) is not int or not 0 <= number <= LARGEST:
        raise InputError.of(
            f"{where}.image_id is {str(image)[:40]!r}", "it should be a number, or end in one"
        )
    return number


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
            text = f"{where}: number {i} is {str(value)[:40]!r}"
            raise InputError.of(text, f"numbers lie within {FARTHEST:.0f}")
        yield float(value)


def _check_count(persons: int, text: str) -> None:
    if persons > MOST_PERSONS:
        raise InputError.of(f"{text} {persons} persons", f"at most {MOST_PERSONS} in a picture")

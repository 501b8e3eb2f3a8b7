"""Files of the shape model and of the relations of colours: what does not fit is refused with the reason."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from followspot import InputError
from followspot_persons.body.shape import SHIPPED, read_shape
from followspot_persons.color.difference import SHIPPED as SHIPPED_RELATIONS
from followspot_persons.color.difference import read_relations


def changed(folder: Path, shipped: Path, *keys: Any, to: Any) -> Path:
    """A copy of a shipped file in which the value at these keys is another."""
    document = copy.deepcopy(yaml.safe_load(shipped.read_text()))
    part = document
    for key in keys[:-1]:
        part = part[key]
    part[keys[-1]] = to
    (folder / "changed.yaml").write_text(yaml.safe_dump(document))
    return folder / "changed.yaml"


@pytest.mark.parametrize(
    ("keys", "to", "reason"),
    [
        (("surface", 3, "outward"), [1.0, 1.0], "longer than a unit vector"),
        (("surface", 3, "outward"), [1e9, 0.0], "longer than a unit vector"),
        (("surface", 3, "outward"), [float("nan"), 0.0], "longer than a unit vector"),
        (("surface", 3, "position"), [float("inf"), 0.0, 0.5], "not finite"),
        (("outline", 2, "width"), 99.0, "no share of the body's height"),
        (("surface",), [], "1 to 1000 entries"),
    ],
)
def test_a_shape_of_no_body_is_refused(tmp_path: Path, keys: tuple[Any, ...], to: Any, reason: str) -> None:
    with pytest.raises(InputError, match=f"(?s)changed.yaml: no shape model.*{reason}.*shape fit"):
        read_shape(changed(tmp_path, SHIPPED, *keys, to=to))


def test_relations_are_of_the_features_of_the_shape(tmp_path: Path) -> None:
    names = read_shape().names
    assert len(read_relations(SHIPPED_RELATIONS, names).mean) == len(names)
    rows = yaml.safe_load(SHIPPED_RELATIONS.read_text())["features"]
    for other in (rows[:40], rows[::-1], [*rows, rows[0]]):
        file = changed(tmp_path, SHIPPED_RELATIONS, "features", to=other)
        with pytest.raises(InputError, match=r"(?s)features are not the 45 of the shape.*shape colors"):
            read_relations(file, names)

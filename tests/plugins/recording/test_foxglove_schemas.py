"""What viewers are shown has the fields that Foxglove's own package of schemas says, and no others."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import pytest

from followspot_recording import schemas
from followspot_recording.recorder import Schema

pytest.importorskip("foxglove_schemas_protobuf")
MESSAGE, ENUM = 11, 14
KINDS = {1: "number", 7: "integer", 8: "boolean", 9: "string", 12: "string", 15: "integer"}
"""JSON's name for each of protobuf's types that occur: double, fixed32, bool, text, bytes, sfixed32."""
TIMES = {"google.protobuf.Timestamp": "time", "google.protobuf.Duration": "duration"}


def differences(where: str, ours: dict[str, Any], theirs: Any) -> Iterator[str]:
    """Where an object's schema and a protobuf descriptor do not say the same."""
    fields = {field.name: field for field in theirs.fields}
    if ours["properties"].keys() != fields.keys():
        yield f"{where} has {sorted(ours['properties'].keys() ^ fields.keys())} on one side only"
    for name, told in ours["properties"].items():
        field = fields.get(name)
        if field is None:
            continue
        item = told["items"] if told.get("type") == "array" else told
        if (told.get("type") == "array") != field.is_repeated:
            yield f"{where}.{name} is one here and several there"
        if field.type == MESSAGE and item.get("title"):
            yield from named_otherwise(f"{where}.{name}", item, field.message_type)
        elif field.type not in (MESSAGE, ENUM) and item["type"] != KINDS[field.type]:
            yield f"{where}.{name} is {item['type']}, theirs {KINDS[field.type]}"


def named_otherwise(where: str, ours: dict[str, Any], theirs: Any) -> Iterator[str]:
    name = TIMES.get(theirs.full_name, theirs.full_name)
    if ours["title"] != name:
        yield f"{where} is {ours['title']}, theirs {name}"
    elif theirs.full_name not in TIMES:
        yield from differences(where, ours, theirs)


OURS = [value for value in vars(schemas).values() if isinstance(value, Schema)]


@pytest.mark.parametrize("schema", OURS, ids=lambda schema: schema.name)
def test_a_schema_has_the_fields_of_foxgloves_own(schema: Schema) -> None:
    name = schema.name.removeprefix("foxglove.")
    theirs = getattr(import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name).DESCRIPTOR
    assert list(differences(name, json.loads(schema.text), theirs)) == []

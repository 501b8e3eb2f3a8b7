"""One schema a kind of file."""

from __future__ import annotations

from typing import Any

from followspot_schema.graph_file import graph_schema
from followspot_schema.placement_file import placement_schema
from followspot_schema.room_file import room_schema

DRAFT = "https://json-schema.org/draft/2020-12/schema"
_MADE_BY = {"graph": graph_schema, "room": room_schema, "placement": placement_schema}


def document(kind: str) -> dict[str, Any]:
    """The schema of "graph", "room" or "placement" files."""
    return {"$schema": DRAFT, "title": f"followspot {kind}", **_MADE_BY[kind]()}

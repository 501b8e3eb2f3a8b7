"""The first layout of the Rerun viewer: the room beside the pictures of its cameras."""

from __future__ import annotations

from typing import Any

from followspot import Room
from followspot_sinks.rerun.scene import ROOT


def layout_of(blueprint: Any, room: Room) -> Any:
    """The blueprint of a room. blueprint: the module `rerun.blueprint`."""
    scene = blueprint.Spatial3DView(origin=ROOT, name=room.name)
    views = [blueprint.Spatial2DView(origin=f"{ROOT}/{name}", name=name) for name in room.cameras]
    parts = [scene, blueprint.Grid(*views)] if views else [scene]
    return blueprint.Blueprint(blueprint.Horizontal(*parts), collapse_panels=True)

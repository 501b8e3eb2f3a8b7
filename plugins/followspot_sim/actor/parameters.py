"""The parameters of a simulated room with people, the same for its cameras and its ground truth."""

from __future__ import annotations

import pydantic

from followspot import Field, StageParams


class ActorParams(StageParams):
    """Who walks in the simulated room, and where; equal parameters give equal rooms."""

    frames: int = Field(600, ge=0, description="length of the recording; 0 never ends", unit="frame")
    fps: float = Field(15.0, ge=0.001, le=1000, description="pictures of each camera per second", unit="1/s")
    seed: int = Field(
        1, ge=0, description="another seed, other people, other ways and another room", unit="1"
    )
    people: int = Field(2, ge=0, le=6, description="who walk, turn and look around", unit="1")
    size: tuple[float, float, float] = Field(
        (6.4, 6.0, 2.7), description="of the room, whose floor has the origin in its middle", unit="m"
    )
    area: tuple[float, float, float, float] = Field(
        (-1.8, -1.6, 1.8, 1.6), description="part of the floor where people walk: x0, y0, x1, y1", unit="m"
    )
    clear: float = Field(
        0.0, ge=0, le=10, description="distance that people keep from the middle of the floor", unit="m"
    )
    cupboard: tuple[float, float] | None = Field(
        None,
        description="where a cupboard stands across the way from the middle, behind which people hide now "
        "and then; none: no cupboard",
        unit="m",
    )
    noise: float = Field(
        2.0, ge=0, le=20, description="standard deviation of sensor noise", unit="grey level"
    )
    realtime: bool = Field(False, description="deliver at the pace of fps instead of as fast as wanted")

    @pydantic.field_validator("area")
    @classmethod
    def _check_area(cls, area: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        if not (area[0] < area[2] and area[1] < area[3]):
            raise ValueError("the area must be x0, y0, x1, y1 with x0 < x1 and y0 < y1")
        return area

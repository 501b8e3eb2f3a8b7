"""Parameters of the detector of coloured balls."""

from __future__ import annotations

from followspot import Field
from followspot_balls.detection.detector import DetectionParams


class ColorParams(DetectionParams):
    """Which pixels are coloured, and which blobs of them are a ball."""

    similarity: float = Field(
        0.8,
        ge=0,
        le=1,
        unit="1",
        description="smallest Bhattacharyya coefficient with the template; raising it rejects more "
        "projections, and balls lit by other colours",
    )
    minimum_saturation: int = Field(
        80,
        ge=0,
        le=255,
        unit="grey levels",
        description="smallest saturation of a coloured pixel; raising it ignores pale light",
    )
    minimum_brightness: int = Field(
        70,
        ge=1,
        le=255,
        unit="grey levels",
        description="smallest brightness of a pixel; raising it ignores dim balls",
    )
    overexposed_brightness: int = Field(
        245,
        ge=1,
        le=256,
        unit="grey levels",
        description="brightness of an overexposed core; 256: none; lowering it accepts more white light",
    )
    minimum_hue_share: float = Field(
        0.02,
        gt=0,
        lt=1,
        unit="1",
        description="smallest histogram share of a target's hue; raising it narrows the colour",
    )
    edge_level: float = Field(
        0.7,
        gt=0,
        lt=1,
        unit="1",
        description="brightness of a blob's edge over its peak; raising it shrinks blobs and separates them",
    )
    radius_offset: float = Field(
        0.0,
        unit="px",
        description="measured minus true radius of a ball; raising it suits overexposed balls",
    )
    maximum_expected_area: float = Field(
        1.8,
        gt=0,
        unit="1",
        description="largest blob area over the area expected at the forecast; larger blobs are kept "
        "only if a rim tells the ball from other light; raising it keeps biased blobs",
    )

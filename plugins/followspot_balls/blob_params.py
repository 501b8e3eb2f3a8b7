"""Parameters of how exactly blobs tell where a ball is."""

from __future__ import annotations

from followspot import Field, StageParams


class BlobParams(StageParams):
    """Errors of the centres of blobs, and of all views together."""

    blob_sigma: float = Field(
        0.2,
        gt=0,
        unit="px",
        description="sigma of a fully visible ball's centre; raising it smooths more",
    )
    hidden_inflation: float = Field(
        4.0,
        ge=0,
        unit="1",
        description="growth of this sigma with the hidden share; raising it trusts small blobs less",
    )
    merged_inflation: float = Field(
        14.0,
        ge=0,
        unit="1",
        description="its growth with the squared excess area; raising it trusts merged blobs less",
    )
    glow_sigma: float = Field(
        0.02,
        ge=0,
        unit="m",
        description="sigma of the shift that a ball's light on a plane causes in colour cameras; "
        "raising it trusts them less along the normal",
    )
    glow_range: float = Field(
        0.35,
        gt=0,
        unit="m",
        description="clearance at which this shift vanishes; raising it corrects farther balls",
    )
    glow_mean: float = Field(
        0.3,
        ge=0,
        unit="sigma",
        description="mean of this shift; 0 suits balls that do not glow; raising it corrects more",
    )
    plane_sigma: float = Field(
        0.004,
        gt=0,
        unit="m",
        description="sigma of the planes' places, into which balls do not sink; raising it suits inexact "
        "planes",
    )
    prior_errors: float = Field(
        4.0,
        gt=0,
        unit="1",
        description="errors that the sigma counts for; raising it adapts the covariance less",
    )

"""Parameters of the errors of blobs as measurements of balls."""

from __future__ import annotations

from followspot import Array, Field, StageParams
from followspot_balls.measurement.center_precision import variance


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
        description="growth of `blob_sigma` with the hidden share of a ball's outline; raising it trusts "
        "small blobs less",
    )
    merged_inflation: float = Field(
        14.0,
        ge=0,
        unit="1",
        description="growth of `blob_sigma` with the square of a blob's excess area over a ball's outline; "
        "raising it trusts merged blobs less",
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
        description="clearance above a plane at which the ball's light on it causes no more shift; raising "
        "it corrects balls farther from planes",
    )
    glow_mean: float = Field(
        0.3,
        ge=0,
        unit="sigma",
        description="mean of the shift that a ball's light on a plane causes in colour cameras, over "
        "`glow_sigma`; 0 suits balls that do not glow; raising it corrects more",
    )
    plane_sigma: float = Field(
        0.004,
        gt=0,
        unit="m",
        description="sigma of the positions of planes; balls do not sink into planes; raising it suits "
        "inexact planes",
    )
    prior_errors: float = Field(
        4.0,
        gt=0,
        unit="1",
        description="weight of `blob_sigma` when the covariance adapts to the errors of a frame: as many "
        "measured errors; raising it adapts the covariance less",
    )

    def center_variance(self, share: Array) -> Array:
        """Variances of the centres of blobs that show these shares of their outlines, px^2; any shape."""
        return variance(share, self.blob_sigma, self.hidden_inflation, self.merged_inflation)

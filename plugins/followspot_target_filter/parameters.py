"""Parameters of filters of targets."""

from __future__ import annotations

from followspot.stage_params import Field, StageParams


class TargetFilterParams(StageParams):
    """The life cycle of targets: when they are confirmed, coasted, doubted and lost."""

    measurement_sigma: float = Field(
        0.008,
        gt=0,
        unit="m",
        description="sigma of a position without a covariance; raising it smooths more",
    )
    maximum_missed_frames: int = Field(
        25,
        ge=0,
        unit="frames",
        description="frames without measurement until a target is lost; raising it bridges more",
    )
    local_search_frames: int = Field(
        4,
        ge=0,
        unit="frames",
        description="frames without measurement in which a target is searched for near its last position "
        "only; after them it is searched for everywhere in every second frame; raising it finds targets "
        "later that reappear elsewhere",
    )
    maximum_predicted_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="largest sigma of a target that only one view shows; beyond it the target is missing; "
        "raising it bridges longer gaps",
    )
    minimum_support: int = Field(
        3,
        ge=1,
        unit="1",
        description="number of candidates that confirm a target or a bounce at once; two are enough if one "
        "of them is evident; raising it avoids mistakes",
    )
    confirmation_frames: int = Field(
        3,
        ge=1,
        unit="frames",
        description="number of successive frames with an evident candidate that confirm a tentative target; "
        "raising it avoids mistakes",
    )
    confirmation_distance: float = Field(
        0.3,
        gt=0,
        unit="m",
        description="largest step of a tentative target between such frames; if the sigma of its position is "
        "larger, the target needs twice as many frames; raising it confirms faster targets, and vague ones",
    )
    return_distance: float = Field(
        0.1,
        ge=0,
        unit="m",
        description="distance from the last measured position within which a single candidate confirms a "
        "missing target, provided that the target was measured at least `maximum_missed_frames` times; 0: "
        "never; raising it finds covered targets sooner, but takes other things for them",
    )
    doubt_frames: int = Field(
        8,
        ge=0,
        unit="frames",
        description="number of successive frames with fewer candidates than `minimum_support`, or with "
        "candidates of cameras of one kind only where both kinds look, after which a tracked target is also "
        "searched for everywhere, in every fifth frame; this needs three cameras with the target in their "
        "pictures, and a colour camera in the room; 0: never; raising it keeps tracks longer that have left "
        "their targets",
    )
    fade_time: float = Field(
        0.1,
        ge=0,
        unit="s",
        description="decay time of a coasting target's velocity; 0: a missing target stops at once",
    )
    marks: dict[str, tuple[float, float, float]] = Field(
        {},
        unit="m",
        description="known positions, by target: a lost target is found at its position only, unless all "
        "other targets are tracked; tells targets apart if no camera sees colours",
    )

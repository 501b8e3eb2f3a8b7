"""Parameters of `persons.pose_tracker`."""

from __future__ import annotations

from typing import Literal

from followspot import Field, InputPath, StageParams
from followspot_persons.body.shape import SHIPPED as SHIPPED_SHAPE
from followspot_persons.color.difference import SHIPPED as SHIPPED_RELATIONS
from followspot_persons.likelihood.fitness import Weights


class PoseTrackerParams(StageParams):
    """The search, the cues and the life cycle."""

    shape: InputPath = Field(SHIPPED_SHAPE, description="shape model of head and upper body")
    particles: int = Field(
        300,
        ge=20,
        le=10_000,
        unit="1",
        description="particles per person; raising it improves poses and costs time",
    )
    random_share: float = Field(
        0.15,
        ge=0,
        le=0.9,
        unit="1",
        description="share of random particles; raising it leaves a wrong pose sooner",
    )
    ascent_share: float = Field(
        0.2,
        ge=0,
        le=1,
        unit="1",
        description="share of particles with gradient ascent; raising it costs time",
    )
    search_rounds: int = Field(
        1,
        ge=1,
        le=100,
        unit="rounds",
        description="rounds of the local search at most; ascent ends when it has converged, and raising it "
        "costs time",
    )
    local_search: Literal["ascent", "swarm"] = Field(
        "ascent", description="local search: gradient ascent, or particle swarm optimisation"
    )
    identity_change_share: float = Field(
        0.0,
        ge=0,
        le=0.5,
        unit="1",
        description="share of a person's particles drawn from those of other persons; raising it undoes "
        "swaps sooner",
    )
    edge_weight: float = Field(
        1.0, gt=0, le=100, unit="1", description="alpha of the edges in eq. 7; raising it trusts outlines"
    )
    color_weight: float = Field(
        1.0, ge=0, le=100, unit="1", description="alpha of the colours in eq. 7; 0 leaves them out"
    )
    color_power: float = Field(
        1.0,
        gt=0,
        le=1,
        unit="1",
        description="power of the colours' likelihood in a particle's weight; lowering it trusts outlines "
        "more for sizes, and turns poses more slowly",
    )
    difference_weight: float = Field(
        0.0,
        ge=0,
        le=100,
        unit="1",
        description="alpha of the differences between colours in eq. 7; 0 leaves them out",
    )
    hog_weight: float = Field(
        1.0, ge=0, le=100, unit="1", description="alpha of the boxes in eq. 7; 0 leaves them out"
    )
    gamma: float = Field(
        0.8,
        ge=0,
        le=1,
        unit="1",
        description="share of the product in eq. 7; raising it lets one bad cue decide",
    )
    likelihood_power: float = Field(
        40.0,
        gt=0,
        le=1000,
        unit="1",
        description="power of eq. 7 in a particle's weight; raising it concentrates particles",
    )
    color_relations: InputPath = Field(
        SHIPPED_RELATIONS, description="how the colours of features relate, to choose pairs of features"
    )
    real_valued_boxes: bool = Field(
        False, description="whether the weight of a box grows with the certainty of its score"
    )
    use_colors: bool = Field(True, description="whether the persons' colours weigh their poses")
    walkable: tuple[tuple[float, float], ...] = Field(
        (),
        unit="m",
        description="corners x, y of the part of the floor where people can be, taken as convex; none: "
        "everywhere",
    )
    minimum_likelihood_share: float = Field(
        0.5,
        gt=0,
        lt=1,
        unit="1",
        description="smallest likelihood over the person's usual one; below it a picture misses the "
        "person; raising it deletes wrong poses sooner, but also persons that are hard to see",
    )
    box_timeout: float = Field(
        0.6,
        gt=0,
        unit="s",
        description="time without a box in which the share of the usual likelihood that a person needs "
        "rises from `minimum_likelihood_share` to 1; raising it keeps persons longer",
    )
    maximum_missed_time: float = Field(
        0.5, gt=0, unit="s", description="time until a missed person is deleted; raising it bridges more"
    )
    maximum_unseen_time: float = Field(
        2.0,
        gt=0,
        unit="s",
        description="time after which a person whom the slow instance does not find is deleted; raising it "
        "keeps persons longer, also after they have left",
    )
    maximum_delay: float = Field(
        2.5,
        ge=0,
        le=10,
        unit="s",
        description="largest delay of the slow instance for which pictures are kept, to track a person "
        "that it finds up to the present; raising it costs memory; 0 keeps no pictures",
    )

    @property
    def weights(self) -> Weights:
        """Of the cues, for :class:`followspot_persons.likelihood.fitness.Fitness`."""
        return Weights(
            edge=self.edge_weight,
            color=self.color_weight,
            difference=self.difference_weight,
            hog=self.hog_weight,
            real_valued=self.real_valued_boxes,
            gamma=self.gamma,
            color_power=self.color_power,
            sharpness=self.likelihood_power,
        )

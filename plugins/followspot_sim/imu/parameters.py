"""The parameters of a simulated inertial sensor; the defaults are those of a small one for consumers."""

from __future__ import annotations

from followspot import Field
from followspot.sensors.reading_batches import BatchParams
from followspot_sim.parameters import SimParams

Vector = tuple[float, float, float]


class PropParams(SimParams):
    """The performance, and how its balls turn."""

    turn_rate: float = Field(
        1.5, ge=0, le=30, unit="rad/s", description="root mean square of the turn rate of every ball"
    )


class ImuParams(PropParams, BatchParams):
    """The performance, and the errors of the sensor."""

    rate: float | None = Field(
        None,
        ge=1,
        le=10_000,
        unit="1/s",
        description="readings a second; by default as the room says, else 200",
    )
    clock_offset: float = Field(
        0.0,
        ge=-1,
        le=1,
        unit="s",
        description="delay of the readings after their time stamps, unknown to the room",
    )
    lever_arm: Vector = Field(
        (0.005, -0.003, 0.008),
        unit="m",
        description="offset of the sensor from the ball's centre, in the axes of the ball",
    )
    contact_time: float = Field(
        0.04,
        gt=0,
        le=1,
        unit="s",
        description="duration of a throw, a catch and a stop, as the sensor feels it",
    )
    turn_noise: float = Field(
        1.2e-4,
        ge=0,
        le=1,
        unit="rad/s/sqrt(Hz)",
        description="noise density of the gyroscope; times the root of the rate, that of a reading",
    )
    turn_bias_sigma: float = Field(
        0.004, ge=0, le=1, unit="rad/s", description="standard deviation of the gyroscope's constant error"
    )
    turn_limit: float = Field(
        34.9, gt=0, le=1000, unit="rad/s", description="largest turn rate about an axis"
    )
    force_noise: float = Field(
        1.2e-3,
        ge=0,
        le=10,
        unit="m/s^2/sqrt(Hz)",
        description="noise density of the accelerometer; times the root of the rate, that of a reading",
    )
    force_bias_sigma: float = Field(
        0.05,
        ge=0,
        le=10,
        unit="m/s^2",
        description="standard deviation of the accelerometer's constant error",
    )
    force_limit: float = Field(
        156.9, gt=0, le=10_000, unit="m/s^2", description="largest specific force along an axis"
    )
    magnetometer: bool = Field(True, description="whether there is one")
    field: Vector = Field(
        (0.0, 19.0, -45.0), unit="uT", description="magnetic field in axes of the room, the same everywhere"
    )
    field_noise: float = Field(
        0.5, ge=0, le=100, unit="uT", description="standard deviation of a reading of the magnetometer"
    )
    field_bias_sigma: float = Field(
        1.0, ge=0, le=100, unit="uT", description="standard deviation of the magnetometer's constant error"
    )

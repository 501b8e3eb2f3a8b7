"""Parameters of `balls.inertial`."""

from __future__ import annotations

from followspot import Field
from followspot_balls.kalman import Kalman


class InertialParams(Kalman.Params):
    """The life cycle, the motion of targets without readings, and the errors of the sensors."""

    gyroscope_noise: float = Field(
        2e-4,
        gt=0,
        unit="rad/s/sqrt(Hz)",
        description="noise density of the gyroscope; raising it trusts turn rates less",
    )
    accelerometer_noise: float = Field(
        4e-3,
        gt=0,
        unit="m/s^2/sqrt(Hz)",
        description="noise density of the accelerometer; raising it trusts forces less",
    )
    gyroscope_scale: float = Field(
        0.002,
        ge=0,
        unit="1",
        description="sigma of the gyroscope's relative errors; raising it trusts fast turns less",
    )
    accelerometer_scale: float = Field(
        0.002,
        ge=0,
        unit="1",
        description="sigma of the accelerometer's relative errors; raising it trusts strong forces less",
    )
    gyroscope_bias: float = Field(
        0.02,
        gt=0,
        unit="rad/s",
        description="sigma of the gyroscope's bias at first; raising it learns larger biases",
    )
    accelerometer_bias: float = Field(
        0.1,
        gt=0,
        unit="m/s^2",
        description="sigma of the accelerometer's bias at first; raising it learns larger biases",
    )
    lever_arm: float = Field(
        0.03,
        gt=0,
        unit="m",
        description="sigma of the sensor's offset from the target; raising it allows larger ones",
    )
    delay: float = Field(
        0.005,
        gt=0,
        unit="s",
        description="sigma of the readings' time stamps; raising it learns larger delays",
    )
    history: float = Field(
        1.0,
        gt=0,
        le=10,
        unit="s",
        description="largest lateness of readings that are used; raising it uses later ones",
    )
    maximum_reading_gap: float = Field(
        0.05,
        gt=0,
        unit="s",
        description="largest gap between readings; in longer gaps the motion is unknown; raising it suits "
        "slow sensors",
    )

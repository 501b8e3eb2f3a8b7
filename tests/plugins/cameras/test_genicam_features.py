"""Features that a user wants, against the node map of a camera: every mistake at once, with a remedy."""

from __future__ import annotations

import pytest

from followspot import InputError
from followspot_cameras.camera_features import Feature, Value, as_text, set_features

FEATURES = {
    feature.name: feature
    for feature in (
        Feature("ExposureTime", "Float", low=10, high=1e6, unit="us"),
        Feature("Width", "Integer", low=16, high=4096),
        Feature("PixelFormat", "Enumeration", entries=("Mono8", "BayerRG8")),
        Feature("ReverseX", "Boolean"),
        Feature("DeviceModelName", "String", writable=False),
        Feature("TriggerSoftware", "Command"),
    )
}


def wrong(written: dict[str, Value] | None = None, **wanted: Value) -> str:
    """What is wrong with these features. written: gets those that are set."""
    kept = {} if written is None else written
    try:
        set_features(wanted, FEATURES, FEATURES.get, kept.__setitem__, "camera 7")
    except InputError as error:
        return "; ".join(f"{mistake.text}: {mistake.remedy}" for mistake in error.mistakes)
    return ""


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("ExposureTim", 5, 'camera 7 has no feature "ExposureTim": did you mean "ExposureTime"?'),
        ("ExposureTime", 5, "ExposureTime of camera 7 cannot be 5: write a number from 10 to 1e+06 us"),
        ("ExposureTime", "long", 'ExposureTime of camera 7 cannot be "long": write a number'),
        ("Width", 20.5, 'Width of camera 7 cannot be "20.5": write a whole number'),
        ("ExposureTime", float("nan"), 'ExposureTime of camera 7 cannot be "nan": write a number'),
        ("Width", float("inf"), 'Width of camera 7 cannot be "inf": write a whole number'),
        ("Width", True, 'Width of camera 7 cannot be "True": write a whole number'),
        ("PixelFormat", "Mono9", 'PixelFormat of camera 7 cannot be "Mono9": did you mean "Mono8"?'),
        ("ReverseX", 1, 'ReverseX of camera 7 cannot be "1": write true or false'),
        ("DeviceModelName", "x", "DeviceModelName of camera 7 cannot be set: leave it out"),
        ("TriggerSoftware", 1, "TriggerSoftware of camera 7 is a command, and has no value: leave it out"),
    ],
)
def test_a_wrong_feature_is_told_with_its_remedy(name: str, value: Value, text: str) -> None:
    assert wrong(**{name: value}).startswith(text)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ExposureTime", 10),
        ("ExposureTime", 99.5),
        ("Width", 640.0),
        ("PixelFormat", "Mono8"),
        ("ReverseX", False),
    ],
)
def test_what_the_camera_takes_is_accepted(name: str, value: Value) -> None:
    written: dict[str, Value] = {}
    assert wrong(written, **{name: value}) == ""
    assert written == {name: value}


def test_every_mistake_is_told_at_once() -> None:
    assert wrong(Widht=1, ExposureTime=1, Width=1).count("camera 7") == 3


def test_a_value_that_the_camera_refuses_is_told_in_its_words() -> None:
    def refuse(name: str, value: Value) -> None:
        raise ValueError("not while pictures are taken")

    with pytest.raises(
        InputError, match=r'camera 7 does not take "20" as Width: not while pictures are taken'
    ):
        set_features({"Width": 20}, FEATURES, FEATURES.get, refuse, "camera 7")


def test_truth_values_are_written_as_node_maps_read_them() -> None:
    assert [as_text(value) for value in (True, 5, 0.5, "Mono8")] == ["true", "5", "0.5", "Mono8"]

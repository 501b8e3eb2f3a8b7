"""The region of the sensor: offset and size limit each other, and features lock others."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from tests.plugins.cameras.genicam_port import own_port
from tests.plugins.cameras.gev_camera import HEIGHT, INTEGERS, START, STOP, WIDTH, GevCamera
from tests.plugins.cameras.gvcp_camera import serving
from tests.plugins.cameras.recordings import context

from followspot import InputError
from followspot_cameras.camera_features import Value

pytest.importorskip("viva_genicam", reason="viva-genicam is not installed")
from followspot_cameras.genicam.stage import Genicam


@pytest.fixture
def camera() -> Iterator[GevCamera]:
    made = GevCamera(fps=60)
    taking = threading.Thread(target=made.work)
    with own_port(), serving(made):
        taking.start()
        yield made
        made.end()
        taking.join()


def stage(features: dict[str, Value], size: tuple[int, int]) -> Genicam:
    where = {"camera": "127.0.0.1", "backend": "viva-genicam", "interface": "127.0.0.1"}
    return Genicam(context("infrared", size), features=features, **where)


@pytest.mark.parametrize("before", [(0, WIDTH), (48, 16)])
@pytest.mark.parametrize("order", [("OffsetX", "Width"), ("Width", "OffsetX")])
def test_a_region_is_set_whatever_its_order_and_whatever_was_set_before(
    camera: GevCamera, before: tuple[int, int], order: tuple[str, str]
) -> None:
    camera.registers |= {INTEGERS["OffsetX"]: before[0], INTEGERS["Width"]: before[1]}
    wanted = {"OffsetX": 24, "Width": 40}
    source = stage({name: wanted[name] for name in order}, (40, HEIGHT))
    frame = next(source.process())
    source.close()
    assert {name: camera.registers[INTEGERS[name]] for name in wanted} == wanted
    assert frame.pixels.shape == (HEIGHT, 40, 1)


def test_a_region_beyond_the_sensor_is_refused_with_what_the_rest_of_it_leaves(camera: GevCamera) -> None:
    with pytest.raises(InputError, match=r"OffsetX of camera 127\.0\.0\.1 cannot be 25.*\n.*from 0 to 24"):
        next(stage({"OffsetX": 25, "Width": 40}, (40, HEIGHT)).process())


def test_a_camera_that_still_takes_pictures_is_stopped_before_its_format_is_set(camera: GevCamera) -> None:
    source = stage({"Width": 40}, (40, HEIGHT))
    next(source.process())
    source.close()
    commands = [at for at, _ in camera.written if at in (START, STOP, INTEGERS["Width"])]
    assert commands[:3] == [STOP, INTEGERS["Width"], START]

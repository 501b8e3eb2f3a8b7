"""A USB3 Vision camera (of viva-genicam): numbers from 0 that do not wrap, and its own clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest
from tests.plugins.cameras.attempts import one_of
from tests.plugins.cameras.recordings import context

testing = pytest.importorskip("viva_genicam.testing", reason="viva-genicam is not installed")
from followspot_cameras.genicam import stage, viva  # noqa: E402
from followspot_cameras.genicam.facts import facts_of  # noqa: E402

SIZE = (64, 48)


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Plugs a camera in, which no search of the bus finds: the stage gets it whatever it asks for."""

    def plug(**options: Any) -> Any:
        camera = testing.FakeU3vCamera(*SIZE, **options)
        monkeypatch.setattr(stage, "connected", lambda *asked: viva.VivaCamera(camera.connect(), "", 0))
        return camera

    return plug


@pytest.mark.parametrize("name", ["Mono8", "BayerRG8", "Mono12p"])
def test_pictures_come_by_their_numbers(plugged: Callable[..., Any], name: str) -> None:
    camera = plugged(pixel_format=name)

    def attempt() -> bool:
        lost: Counter[str] = Counter()
        found = replace(context("color", SIZE), lost=lambda kind, number: lost.update({kind: number}))
        source = stage.Genicam(found)
        pictures = source.process()
        frames = list(islice(pictures, 5))
        assert camera.acquiring()
        source.close()
        assert list(pictures) == []
        assert not camera.acquiring()
        assert frames[0].pixels.shape == (48, 64, 3)
        assert (np.diff([frame.header.time for frame in frames]) > 0).all()
        return [frame.header.seq for frame in frames] == list(range(5)) and not +lost

    assert one_of(4, attempt)


def test_its_clock_can_be_read(plugged: Callable[..., Any]) -> None:
    camera = viva.VivaCamera(plugged().connect(), "", 0)
    told, first, second = facts_of(camera), camera.read_clock(), camera.read_clock()
    camera.close()
    assert (told.size, told.format, told.clock) == (SIZE, "Mono8", "readable")
    assert first is not None
    assert second is not None
    assert first.camera <= second.camera

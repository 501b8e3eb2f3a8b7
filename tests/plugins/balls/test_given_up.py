"""A track that is given up is silent: no single view goes on reporting it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.made_candidates import BALL, EVERYWHERE, INFRARED, ROOM, Place, views
from tests.plugins.balls.scene import RADIUS, look_at

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.room import Room
from followspot.tracking import PREDICTED, TRACKED, Blobs, Forecast
from followspot_balls.associate import Associate
from followspot_balls.associate_tracked import AssociateTracked
from followspot_balls.bridge import Bridge
from followspot_balls.bundle_fusion import Bundle
from followspot_balls.kalman import Kalman
from followspot_balls.mean_shift import MeanShift
from followspot_balls.triangulate import Triangulate
from followspot_balls.verify_pairs import VerifyPairs

FPS = 30
CORNERS = (-2.5, 2.5, 2.5), (2.5, -2.5, 2.5)
"""Places of further cameras, m."""
RESTING: Place = (0.1, 0.2, RADIUS)
Association = type[Associate] | type[AssociateTracked]
Fusion = type[MeanShift] | type[Bundle]


def reported(
    frames: Iterable[Sequence[Blobs]], association: Association, fusion: Fusion, room: Room = ROOM
) -> list[int | None]:
    """The state of the first target in each frame, None if it is not reported."""
    context = Context(room=room)
    verify, triangulate, associate = VerifyPairs(context), Triangulate(context), association(context)
    fuse, bridge, track = fusion(context), Bridge(context), Kalman(context)
    for stage in (verify, triangulate, associate, fuse, bridge, track):
        stage.setup()
    forecast: Forecast | None = None
    states: list[int | None] = []
    for number, blobs in enumerate(frames):
        candidates = seal(triangulate.process(seal(verify.process(tuple(blobs), forecast)), forecast))
        associated = associate.process(candidates, forecast)
        positions = seal(fuse.process(seal(associated.candidates), forecast))
        bridged = seal(bridge.process(positions, tuple(blobs), forecast, (seal(associated.existence),)))
        moment = Header("test", number, round(number * 1e9 / FPS))
        outputs = track.process(seal(stamped(bridged, moment)))
        forecast = seal(outputs.forecast)
        mine = np.flatnonzero(outputs.tracks.target == 0)
        states.append(int(outputs.tracks.state[mine[0]]) if len(mine) else None)
    return states


@pytest.mark.parametrize("association", [Associate, AssociateTracked])
@pytest.mark.parametrize("fusion", [MeanShift, Bundle])
@pytest.mark.parametrize("place", [BALL, RESTING])
def test_what_infrared_cameras_alone_show_is_silent_once_it_is_given_up(
    association: Association, fusion: Fusion, place: Place
) -> None:
    ball, reflector = views({place: EVERYWHERE}), views({place: INFRARED})
    states = reported([ball] * 20 + [reflector] * 60, association, fusion)
    given_up = states.index(None, 20)
    assert given_up < 20 + FPS
    assert states[given_up:] == [None] * (80 - given_up)
    assert PREDICTED not in states[:28]  # from then on it is doubted, and sought elsewhere in some frames


@pytest.mark.parametrize("fusion", [MeanShift, Bundle])
def test_what_several_infrared_cameras_show_is_silent_once_it_is_given_up_and_returns_in_its_colour(
    fusion: Fusion,
) -> None:
    """Three blobs of it make three candidates, which find a missing target at its last position."""
    more = {f"cam{k}": look_at(f"cam{k}", "infrared", xyz) for k, xyz in enumerate(CORNERS, start=4)}
    room = replace(ROOM, cameras={**ROOM.cameras, **more})
    ball = views({BALL: (*EVERYWHERE, *more)}, room=room)
    reflector = views({BALL: (*INFRARED, *more)}, room=room)
    states = reported([ball] * 20 + [reflector] * 30 + [ball] * 10, AssociateTracked, fusion, room)
    given_up = states.index(None, 20)
    assert given_up < 40
    assert states[given_up:50] == [None] * (50 - given_up)
    assert states[53:] == [TRACKED] * 7


def test_one_infrared_view_goes_on_for_a_second_in_which_no_colour_camera_shows_the_ball() -> None:
    """On the floor, which tells the depth, infrared pairs prolong the track first, then one view does."""
    frames = [views({RESTING: EVERYWHERE})] * 20
    frames += [views({RESTING: INFRARED})] * 8 + [views({RESTING: INFRARED[:1]})] * 52
    states = reported(frames, AssociateTracked, Bundle)
    assert states[28:48] == [PREDICTED] * 20
    assert states[20 + FPS + 1 :] == [None] * (60 - FPS - 1)

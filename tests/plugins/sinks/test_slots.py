"""Which tracker slot each target and person has, also after a restart of the worker."""

from __future__ import annotations

import json
import socket
from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.sinks.shows import ROOM, posed, poses, received, tracks

from followspot import Context, Header
from followspot.control.checkpoint import state_from_data, state_to_data
from followspot.messages import stamped
from followspot_sinks.osc import Osc
from followspot_sinks.psn.stage import Psn
from followspot_sinks.slots.persons import PersonSlots
from followspot_sinks.slots.targets import TargetSlots


def test_nobody_whose_place_is_unknown_takes_a_slot() -> None:
    gone = replace(poses(0.0, 4), heading=np.array([np.nan]))
    assert PersonSlots(2, hold=3.0).after(stamped(gone, Header("pose", 0, 0))).names == ("", "")


def test_a_person_keeps_a_slot_until_gone_for_good() -> None:
    slots = PersonSlots(2, hold=3.0)
    assert slots.after(poses(0.0, 4, 9)).names == ("person 4", "person 9")
    shown = slots.after(poses(0.5, 9))
    assert shown.known.tolist() == [False, True]
    assert shown.velocity[1].tolist() == [0.0, 1.0, 0.0]
    assert shown.position[0].tolist() == [4.0, 0.0, 1.75]  # where person 4 was last
    assert slots.after(poses(1.0, 9, 5)).known.tolist() == [False, True]  # no slot is free yet
    assert slots.after(poses(3.5, 9, 5)).names == ("person 5", "person 9")


def test_a_slot_is_kept_for_the_whole_time_that_it_is_held() -> None:
    slots = PersonSlots(1, hold=3.0)
    slots.after(poses(0.0, 4))
    assert slots.after(poses(3.0, 9)).names == ("person 4",)
    assert slots.after(poses(3.1, 9)).names == ("person 9",)


def test_who_was_not_seen_in_the_frame_before_has_no_velocity_yet() -> None:
    slots = PersonSlots(1, hold=3.0)
    slots.after(poses(0.0, 4))
    slots.after(poses(0.5))
    assert slots.after(poses(1.0, 4)).velocity.tolist() == [[0.0, 0.0, 0.0]]
    assert slots.after(poses(1.5, 4)).velocity.tolist() == [[0.0, 1.0, 0.0]]


def test_an_orientation_is_sent_as_a_unit_quaternion_and_one_of_no_size_keeps_the_last() -> None:
    slots = TargetSlots(("red",))
    message = posed(0, (0.0, 0.0, 0.0), 0)
    far = stamped(replace(message, quaternion=np.array([[-2.0, 0.0, 0.0, 0.0]])), message.header)
    assert slots.after(far).quaternion.tolist() == [[1.0, 0.0, 0.0, 0.0]]
    none = stamped(replace(message, quaternion=np.full((1, 4), 1e-9)), message.header)
    assert slots.after(none).quaternion.tolist() == [[1.0, 0.0, 0.0, 0.0]]


def test_persons_keep_their_slots_when_the_worker_is_started_again() -> None:
    slots = PersonSlots(3, hold=3.0)
    slots.after(poses(0.0, 4, 9, 5))
    slots.after(poses(3.5, 9, 5))
    sent = slots.after(poses(3.6, 5))
    again = PersonSlots(3, hold=3.0)
    again.restore(state_from_data(json.loads(json.dumps(state_to_data(slots.state())))))
    resumed = again.after(poses(3.7, 5, 9))
    assert resumed.names == ("", "person 9", "person 5")
    assert resumed.velocity[2].tolist() == pytest.approx([0, 1, 0])
    assert resumed.position[0].tolist() == sent.position[0].tolist(), "it stays where it was"
    fewer = PersonSlots(2, hold=3.0)
    fewer.restore(slots.state())
    assert fewer.after(poses(3.7, 9, 6)).names == ("person 6", "person 9")


@pytest.mark.parametrize("kind", [Osc, Psn])
def test_a_target_that_is_not_tracked_stays_where_it_was_when_the_worker_is_started_again(
    kind: type[Osc | Psn], receiver: socket.socket
) -> None:
    sink, again = (kind(Context(room=ROOM), port=receiver.getsockname()[1]) for _ in range(2))
    received(sink, [tracks(0, 0, 1)], receiver)
    again.setup()
    again.restore(sink.state())
    again.process(tracks(1, 0))
    before, after = sink.keeper.slots, again.keeper.slots
    assert after.position[1].tolist() == before.position[1].tolist() != [0.0, 0.0, 0.0]
    assert (after.names, after.known.tolist()) == (("red", "green", "blue"), [True, False, False])
    again.close()


def test_a_person_who_is_seen_keeps_a_slot_that_is_held_for_nobody() -> None:
    """Frames are farther apart than slots are held, and person 5 comes as person 4 leaves."""
    slots = PersonSlots(2, hold=0.0)
    slots.after(poses(0.0, 4, 9))
    assert slots.after(poses(0.5, 9)).names == ("", "person 9")
    shown = slots.after(poses(1.0, 9, 5))
    assert shown.names == ("person 5", "person 9")
    later = slots.after(poses(1.5, 9, 7))
    assert later.names == ("person 7", "person 9")
    assert later.velocity.tolist() == [[0, 0, 0], [0, 1, 0]]  # not from the place of person 5

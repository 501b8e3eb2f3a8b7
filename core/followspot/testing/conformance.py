"""The conformance kit: a plugin's test calls `check_stage(MyStage)`; built-in stages pass the same checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from followspot.ports.signature import SignatureError, ports
from followspot.room import Room
from followspot.stage import Stage
from followspot.testing.promises import (
    checkpoints,
    closing,
    declaration,
    fresh_process,
    memory,
    messages,
    sources,
    work,
)
from followspot.testing.tiny_room import tiny_room
from followspot.testing.trial import Trial

Promise = Callable[[Trial], Iterator[str]]

PROMISES: tuple[Promise, ...] = (
    declaration.is_documented,
    declaration.has_readable_ports,
    declaration.is_found_by_its_name,
    declaration.describes_its_parameters,
    declaration.states_its_units,
    declaration.has_defaults_within_its_limits,
    declaration.refuses_unknown_parameters,
    declaration.keeps_its_parameters,
    declaration.takes_its_parameters_back,
    messages.speaks_empty_messages_that_travel,
    messages.speaks_messages_that_travel,
    messages.speaks_unknown_numbers_that_travel,
    messages.refuses_messages_cut_short,
    work.leaves_empty_inputs_alone,
    work.takes_plausible_inputs,
    work.takes_unknown_numbers,
    work.takes_a_picture_of_one_pixel,
    work.takes_a_white_picture,
    work.takes_noise,
    work.goes_on_without_a_camera,
    work.takes_the_same_frame_twice,
    work.takes_a_late_frame,
    work.takes_a_gap,
    work.leaves_its_inputs_as_they_were,
    work.sends_what_it_declares,
    work.leaves_what_it_sent_alone,
    work.gives_the_same_again,
    work.leaves_the_random_numbers_of_others_alone,
    work.prints_nothing,
    work.does_together_what_it_does_alone,
    closing.closes_without_setup,
    closing.closes_twice,
    closing.closes_within_a_second,
    closing.leaves_no_thread_behind,
    closing.leaves_no_file_open,
    checkpoints.has_a_state_of_plain_values,
    checkpoints.carries_on_from_its_state,
    memory.keeps_its_memory,
    fresh_process.does_the_same_in_a_fresh_process,
    sources.yields_what_it_declares,
    sources.never_goes_back_in_time,
    sources.tells_its_capture_times,
    sources.yields_the_same_again,
    sources.stops_within_a_second,
)


class Finding(NamedTuple):
    """A promise that a stage breaks, and the remedy."""

    promise: str
    text: str


def check_stage(stage: type[Stage], *, room: Room | None = None, messages: int = 2000, **params: Any) -> None:
    """Raise AssertionError with every broken promise of a stage class.

    room: for the trial, by default the tiny room; messages: number over which the growth of memory is
    measured; params: required parameters.
    """
    found = list(findings(stage, room=room, messages=messages, **params))
    assert not found, "\n".join(f"{stage.__name__}: {f.promise}: {f.text}" for f in found)


def findings(
    stage: type[Stage], *, room: Room | None = None, messages: int = 2000, **params: Any
) -> Iterator[Finding]:
    """Every broken promise of a stage class."""
    trial = Trial(stage, params, room or tiny_room(), messages)
    try:
        ports(stage)
    except SignatureError as error:  # without ports nothing else can be tried
        yield Finding("has readable ports", str(error))
        return
    for promise in PROMISES:
        for text in promise(trial):
            yield Finding(promise.__name__.replace("_", " "), text)

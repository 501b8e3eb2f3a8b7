"""Promises about `process`."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from followspot.errors import FollowspotError
from followspot.message_checks.outputs import WrongOutput, check_one_of_several, check_returned
from followspot.message_checks.sealing import seal
from followspot.messages import UNSTAMPED, InvalidMessage, Message, identical
from followspot.testing.printed import printed_by
from followspot.testing.samples import BLACK
from followspot.testing.trial import PERIOD, Trial, noise, outputs, reason

ONE_PIXEL = np.full((1, 1, 3), 128, np.uint8)
WHITE = np.full_like(BLACK, 255)


def leaves_empty_inputs_alone(trial: Trial) -> Iterator[str]:
    """Empty messages and black pictures raise nothing, not even in numpy's strictest mode."""
    with np.errstate(all="raise"):
        yield from _tried(trial, "empty inputs raise", [trial.inputs()])


def takes_plausible_inputs(trial: Trial) -> Iterator[str]:
    """A row of numbers and a picture without sense raise nothing."""
    frames = [trial.inputs("plausible", n, noise(n)) for n in range(3)] if trial.computes else []
    yield from _tried(trial, "three frames of plausible inputs raise", frames)


def takes_unknown_numbers(trial: Trial) -> Iterator[str]:
    """NaN is a value: whatever a stage makes of it, it raises nothing."""
    frames = [trial.inputs("unknown", n, noise(n)) for n in range(2)] if trial.computes else []
    yield from _tried(trial, "inputs of NaN raise", frames)


def takes_a_picture_of_one_pixel(trial: Trial) -> Iterator[str]:
    """A camera may send pictures of another size than the room says; the smallest is one pixel."""
    yield from _tried(trial, "a picture of one pixel raises", [_frame(trial, ONE_PIXEL)])


def takes_a_white_picture(trial: Trial) -> Iterator[str]:
    """The lights of the house may go on."""
    yield from _tried(trial, "a white picture raises", [_frame(trial, WHITE)])


def takes_noise(trial: Trial) -> Iterator[str]:
    """A broken cable may send anything."""
    yield from _tried(trial, "a picture of noise raises", [_frame(trial, noise())])


def goes_on_without_a_camera(trial: Trial) -> Iterator[str]:
    """A join has one message less if a camera is gone, and none if all are."""
    inputs = [
        () if port.several else value for port, value in zip(trial.ports.inputs, trial.inputs(), strict=True)
    ]
    if () in [value for value in inputs if isinstance(value, tuple)]:
        yield from _tried(trial, "a join without any camera raises", [inputs])


def takes_the_same_frame_twice(trial: Trial) -> Iterator[str]:
    """A camera may send a frame again."""
    frames = [trial.inputs("plausible", 4, noise())] * 2 if trial.computes else []
    yield from _tried(trial, "the same frame twice raises", frames)


def takes_a_late_frame(trial: Trial) -> Iterator[str]:
    """A clock may go back."""
    frames = [trial.inputs("plausible", n, noise(n)) for n in (9, 3)] if trial.computes else []
    yield from _tried(trial, "a frame from before the last one raises", frames)


def takes_a_gap(trial: Trial) -> Iterator[str]:
    """A network may be away for an hour."""
    frames = [trial.inputs("plausible", n, noise(n)) for n in (0, 108_000)] if trial.computes else []
    yield from _tried(trial, "a frame an hour later raises", frames)


def leaves_its_inputs_as_they_were(trial: Trial) -> Iterator[str]:
    """Other stages hold the same message; its arrays are read-only and keep their values."""
    if not trial.computes:
        return
    inputs, untouched = (trial.inputs("plausible", 0, noise()) for _ in range(2))
    try:
        with trial.at_work() as stage:
            trial.called(stage, inputs)
    except Exception:
        return  # takes_plausible_inputs says so
    pairs = zip(_flat(inputs), _flat(untouched), strict=True)
    if not all(identical(now, before) for now, before in pairs):
        yield "process writes into its inputs; copy what you change"


def sends_what_it_declares(trial: Trial) -> Iterator[str]:
    """Outputs have the declared type, dtypes and shapes, and no time of their own."""
    for frame, result in enumerate(_returned(trial)):
        try:
            if trial.ports.gives == "several":
                _check_several(trial, result or (), frame)
            elif trial.ports.gives == "lagged":
                _check_lagged(trial, result or (), frame)
            elif result is not None:
                check_returned(trial.ports.outputs, result)
            for message in outputs(result):
                trial.seal(message)
        except WrongOutput as error:
            yield f"process {error}"
        except InvalidMessage as error:
            yield f"what process returns breaks its contract: {error}"


def leaves_what_it_sent_alone(trial: Trial) -> Iterator[str]:
    """A message that was sent belongs to its readers: later frames change nothing in it."""
    if not trial.computes or not trial.ports.outputs:
        return
    try:
        with trial.at_work() as stage:
            first = outputs(trial.called(stage, trial.inputs("plausible", 0, noise(0))))
            before = [contents(message) for message in first]
            for n in range(1, 4):
                trial.called(stage, trial.inputs("plausible", n, noise(n)))
    except Exception:
        return
    if [contents(message) for message in first] != before:
        yield "process reuses an array that it has sent; make a new one for each message"


def gives_the_same_again(trial: Trial) -> Iterator[str]:
    """Two instances under one seed give the same, bit for bit: use `self.rng`, no clock, no `hash`."""
    first, second = sent(trial), sent(trial)
    if [contents(message) for message in first] != [contents(message) for message in second]:
        yield "two instances with one seed give different outputs"


def leaves_the_random_numbers_of_others_alone(trial: Trial) -> Iterator[str]:
    """Numpy's global generator is shared by all stages of a worker."""
    before = np.random.get_state(legacy=False)  # noqa: NPY002  # the one to guard
    sent(trial)
    after = np.random.get_state(legacy=False)  # noqa: NPY002
    if repr(before) != repr(after):
        yield "process draws from numpy's global generator; use self.rng"


def prints_nothing(trial: Trial) -> Iterator[str]:
    """Standard output is the command's; a stage warns with `self.context.warn`."""
    if not trial.ports.outputs:
        return
    if printed := printed_by(lambda: sent(trial)):
        yield f"process prints {printed[:60]!r}; use self.context.warn"


def does_together_what_it_does_alone(trial: Trial) -> Iterator[str]:
    """`process_together` returns what `process` of each stage returns, bit for bit, for noise too."""
    together = trial.stage.process_together
    names = list(trial.room.cameras)[:2]
    if together is None or not trial.computes or len(names) < 2:
        return
    pictures = [noise(), noise()[::-1].copy()]
    inputs = [trial.inputs("empty", 0, p, name) for p, name in zip(pictures, names, strict=True)]
    try:
        with trial.at_work(names[0]) as one, trial.at_work(names[1]) as other:
            alone = [trial.called(one, inputs[0]), trial.called(other, inputs[1])]
            found = together([one, other], inputs)
        for one_alone, one_together in zip(alone, found, strict=True):
            pairs = zip(outputs(one_alone), outputs(one_together), strict=True)
            if not all(identical(seal(a), seal(b)) for a, b in pairs):
                yield "process_together returns something else than process"
    except Exception as error:
        yield f"together they raise {reason(error)}"


def _tried(trial: Trial, what: str, frames: Sequence[list[Any]]) -> Iterator[str]:
    """Call `process` with the inputs of each frame; the error that it raises, unless it is one for users."""
    if not trial.computes or not frames:
        return
    try:
        with trial.at_work() as stage:
            for inputs in frames:
                trial.called(stage, inputs)
    except FollowspotError:
        return
    except Exception as error:
        yield f"{what} {reason(error)}"


def sent(trial: Trial) -> list[Message]:
    """The messages of an instance for three frames."""
    return [message for result in _returned(trial) for message in outputs(result)]


def _check_several(trial: Trial, items: Sequence[Any], frame: int) -> None:
    """Check the results of the firing with a frame. Raises WrongOutput."""
    newest = frame * PERIOD - 1
    for item in items:
        given = check_one_of_several(trial.ports.outputs, item)
        time = frame * PERIOD if given is UNSTAMPED else given.time
        if time <= newest:
            raise WrongOutput("gave messages whose times do not rise from that of the firing on")
        newest = time


def _check_lagged(trial: Trial, items: Sequence[Any], frame: int) -> None:
    """Check the results of the firing with a frame, or of what remains. Raises WrongOutput."""
    newest = -1
    for item in items:
        given = check_one_of_several(trial.ports.outputs, item)
        if given is UNSTAMPED or not newest < given.time <= frame * PERIOD:
            raise WrongOutput("gave messages whose times do not rise up to that of the firing")
        newest = given.time


def _returned(trial: Trial) -> list[Any]:
    """The results of an instance for three frames; empty if it fails, which other promises report."""
    returned: list[Any] = []
    if trial.computes:
        with contextlib.suppress(Exception), trial.at_work(seed=1) as stage:
            returned.extend(trial.called(stage, trial.inputs("plausible", n, noise(n))) for n in range(3))
            if trial.ports.gives == "lagged":
                returned.append(tuple(stage.remaining()))
    return returned


def _frame(trial: Trial, pixels: Any) -> list[Any]:
    return trial.inputs("empty", 0, pixels)


def _flat(inputs: Sequence[Any]) -> list[Message]:
    return [m for value in inputs for m in (value if isinstance(value, tuple) else (value,)) if m is not None]


def contents(message: Message) -> tuple[Any, ...]:
    scalars = [getattr(message, name) for name, _ in message.scalars]
    return (repr(scalars), *(np.asarray(getattr(message, c.name)).tobytes() for c in message.columns))

"""Stage `lsl.stream`: a stream of the Lab Streaming Layer as a live source."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from followspot import Array, Field, Source, Stage, at
from followspot.errors import FollowspotError
from followspot_lsl.library import LslParams, load, wall_clock_offset
from followspot_lsl.samples import Samples

MOST_CHANNELS, LONGEST_LABEL = 1000, 100
WAIT = 0.1
"""Longest wait for a stream or a sample before the stage looks whether the run ends, s."""
ANSWER = 5.0
"""Time in which a stream must describe its channels, s."""


class Stream(Stage):
    """Samples of numbers from another program, by the Lab Streaming Layer.

    The stage waits until there is a stream of this name, type and source. Capture times are those of the
    samples, corrected by liblsl for the offset of the sender's clock. liblsl does not report losses. If the
    times of two samples of a regular stream are more than one and a half periods apart, the ledger counts the
    missing samples as lost (`gap`). If a sender stamps its samples unevenly, this count is too high.
    """

    live: ClassVar[bool] = True

    class Params(LslParams):
        """Which stream."""

        name: str = Field("", pattern=r"^[\w .:-]{0,100}$", description="name of the stream; empty: any")
        type: str = Field(
            "", pattern=r"^[\w .:-]{0,100}$", description="type of the stream, such as EEG; empty: any"
        )
        source_id: str = Field(
            "", pattern=r"^[\w .:-]{0,100}$", description="source of the stream; empty: any"
        )
        batch: int = Field(
            100, ge=1, le=10_000, unit="samples", description="largest number of samples in a message"
        )

    params: Params

    def setup(self) -> None:
        """Load the library. Raises InputError, FollowspotError."""
        self.pylsl = load(self.params)

    def process(self) -> Source[Samples]:
        """A message of the samples that have come. Raises FollowspotError for texts or too many channels."""
        found = self._found()
        if found is None:
            return
        inlet = self.pylsl.StreamInlet(found, max_buflen=60)
        try:
            name, channels = found.name(), labels_of(inlet.info(ANSWER))
            rate, last = found.nominal_srate(), None
            while self.context.pause(0.0):
                samples, stamps = inlet.pull_chunk(WAIT, self.params.batch)
                if not stamps:
                    continue
                times = np.asarray(stamps) + inlet.time_correction(ANSWER)
                self._count_gaps(times if last is None else np.append(last, times), rate)
                last = times[-1]
                yield message_of(
                    name, channels, times, np.asarray(samples, float), wall_clock_offset(self.pylsl)
                )
        except self.pylsl.TimeoutError as error:
            raise FollowspotError(f"the stream {found.name()!r} does not answer: {error}") from None
        finally:
            inlet.close_stream()

    def _found(self) -> Any:
        """The description of the stream; None if the run ends before there is one."""
        wanted = {key: getattr(self.params, key) for key in ("name", "type", "source_id")}
        query = " and ".join(f"{key}='{value}'" for key, value in wanted.items() if value) or "name!=''"
        while self.context.pause(0.0):
            if found := self.pylsl.resolve_bypred(query, 1, WAIT):
                if len(found) > 1:
                    self.context.warn(f"{len(found)} streams fit; this is {found[0].source_id()!r}")
                return checked(found[0])
        return None

    def _count_gaps(self, times: Array, rate: float) -> None:
        """Count the samples that a regular stream left out. times: s; the first one is known from before."""
        missing = np.rint(np.diff(times) * rate).astype(int) - 1
        if rate > 0 and (missing > 0).any():
            self.context.lost("gap", int(missing[missing > 0].sum()))


def checked(info: Any) -> Any:
    """The description, if its samples are numbers and not too many. Raises FollowspotError."""
    if info.channel_format() not in (1, 2, 4, 5, 6, 7):  # float, double, and whole numbers
        raise FollowspotError(f"the stream {info.name()!r} has texts, and lsl.stream takes numbers")
    if not 1 <= info.channel_count() <= MOST_CHANNELS:
        raise FollowspotError(f"the stream {info.name()!r} has more than {MOST_CHANNELS} channels")
    return info


def labels_of(info: Any) -> tuple[str, ...]:
    """Labels of the channels; the number of a channel that has none, or one that is taken."""
    labels: list[str] = []
    channel = info.desc().child("channels").child("channel")
    for number in range(info.channel_count()):
        label = channel.child_value("label")[:LONGEST_LABEL]
        labels.append(label if label and label not in labels else str(number))
        channel = channel.next_sibling()
    return tuple(labels)


def message_of(name: str, channels: tuple[str, ...], times: Array, samples: Array, offset: int) -> Samples:
    """times: (N,) s by liblsl's clock; samples: (N, C); offset: to this host's clock, ns."""
    nanoseconds = np.rint(times * 1e9).astype("i8") + offset
    count = len(channels)
    channel = np.tile(np.arange(count, dtype="i4"), len(times))
    message = Samples(name, channels, np.repeat(nanoseconds, count), channel, samples.ravel())
    return at(int(nanoseconds[-1]), message)

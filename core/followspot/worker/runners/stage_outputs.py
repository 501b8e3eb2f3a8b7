"""The outputs of one stage: each sends its part of what `process` returns, or announces a watermark."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from followspot.messages import Header
from followspot.ports.firing import FIRINGS
from followspot.ports.specs import ONE_OUTPUT, Ports
from followspot.transport.token import UNKNOWN
from followspot.worker.output_port import OutputPort


class StageOutputs:
    """The output ports of a stage by name; also `FIRINGS` if the run records them."""

    def __init__(self, ports: Mapping[str, OutputPort]) -> None:
        self._ports = tuple(ports.items())
        self._results = tuple(named for named in self._ports if named[0] != FIRINGS)
        """The ports of what `process` returns."""
        self.single = self._results[0][1] if [name for name, _ in self._results] == [ONE_OUTPUT] else None
        """The port of a stage that returns messages of one type; else None."""
        self.none = not self._results
        """Whether `process` returns nothing: the stage is a sink."""
        self.firings = ports.get(FIRINGS)
        """The port of the recorded firings; None if the run does not record them."""

    def __iter__(self) -> Iterator[tuple[str, OutputPort]]:
        return iter(self._ports)

    def has_room(self) -> bool:
        """Whether every port has credit for a message."""
        for _, output in self._ports:  # noqa: SIM110  # asked before every firing; all() costs twice as much
            if not output.has_room():
                return False
        return True

    def send(self, result: Any, header: Header, following: int = UNKNOWN) -> None:
        """Send what `process` returned; a port without a message still advances its watermark.

        following: the watermark after it, ns, if more is known than what the message itself announces.
        """
        if self.single is not None:
            self.single.send(result, header, following)
            return
        for port, output in self._results:
            output.send(None if result is None else getattr(result, port), header, following)

    def advance(self, watermark: int) -> None:
        """Announce on all ports that nothing earlier will come, ns."""
        for _, output in self._ports:
            output.advance(watermark)

    def absent(self) -> None:
        """Announce on all ports that nothing comes for now, so that joins downstream do not wait."""
        for _, output in self._ports:
            output.absent()

    def end(self) -> None:
        """End the streams of all ports."""
        for _, output in self._ports:
            output.end()

    def keep(self, declared: Ports) -> None:
        """Keep only the ports that another stage in place of this one has."""
        self._ports = tuple(named for named in self._ports if declared.output(named[0]) is not None)
        self._results = tuple(named for named in self._results if named in self._ports)

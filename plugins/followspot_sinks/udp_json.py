"""Any message as a JSON datagram."""

from __future__ import annotations

from followspot import Field, Message
from followspot_sinks.datagrams import DatagramSink
from followspot_sinks.json_lines import json_text

MOST_BYTES = 65_507
"""Longest UDP datagram."""


class UdpJson(DatagramSink):
    """Send a JSON object per message, as `sinks.jsonl` writes it."""

    class Params(DatagramSink.Params):
        port: int = Field(9001, ge=1, le=65535, unit="1", description="UDP port of the receiver")

    params: Params

    def setup(self) -> None:
        """Open the socket. Raises InputError if the host is unknown."""
        super().setup()
        self.too_long = False

    def process(self, message: Message) -> None:
        """Send one message; warn once of messages that do not fit into a datagram."""
        if self.network is None:
            return
        packet = json_text(message, self.room).encode()
        if len(packet) <= MOST_BYTES:
            self.network.send(packet)
        elif not self.too_long:
            self.too_long = True
            kind = type(message).__name__
            self.context.warn(f"{kind} of {len(packet)} bytes does not fit into a datagram and is not sent")

"""Any message as a JSON datagram."""

from __future__ import annotations

import json

from followspot import Field, Message
from followspot.message_table import as_json
from followspot_sinks.datagrams import DatagramSink

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
        packet = json.dumps(as_json(message, self.room), allow_nan=False, separators=(",", ":")).encode()
        if len(packet) <= MOST_BYTES:
            self.network.send(packet)
        elif not self.too_long:
            self.too_long = True
            kind = type(message).__name__
            self.context.warn(f"{kind} of {len(packet)} bytes does not fit into a datagram and is not sent")

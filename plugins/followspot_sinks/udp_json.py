"""Any message as a datagram of JSON, for programs that speak nothing else."""

from __future__ import annotations

import json

from followspot import Field, Message, OutputHost, Stage, StageParams
from followspot_sinks.datagrams import Datagrams
from followspot_sinks.json_lines import as_json

MOST_BYTES = 65_507
"""Longest UDP datagram."""


class UdpJson(Stage):
    """Send a JSON object per message: its type, source, seq, time (ns) and every field; NaN becomes null."""

    class Params(StageParams):
        host: OutputHost = Field("127.0.0.1", description="receiver: name, address or multicast group")
        port: int = Field(9001, ge=1, le=65535, description="UDP port of the receiver", unit="1")
        interface: str = Field("127.0.0.1", description="own address to send into, for a multicast group")

    params: Params
    network: Datagrams | None = None

    def setup(self) -> None:
        """Open the socket. Raises InputError where the host is unknown."""
        p = self.params
        self.network = Datagrams(p.host, p.port, p.interface, self.context.warn)
        self.too_long = False

    def process(self, message: Message) -> None:
        """Send one message; one that does not fit into a datagram is told of once."""
        if self.network is None:
            return
        packet = json.dumps(as_json(message), allow_nan=False, separators=(",", ":")).encode()
        if len(packet) <= MOST_BYTES:
            self.network.send(packet)
        elif not self.too_long:
            self.too_long = True
            kind = type(message).__name__
            self.context.warn(f"{kind} of {len(packet)} bytes does not fit into a datagram and is not sent")

    def close(self) -> None:
        """Close the socket."""
        if self.network is not None:
            self.network.close()

"""Any port of a run that has begun, to a recorder in another process."""

from __future__ import annotations

from followspot.taps.port_tap import PortTap


class RecordingTap(PortTap):
    """Send every message of a port to a recorder in another process.

    The worker packs the message; a thread sends it. The tap drops what the recorder does not take in time,
    and the recorder counts the gaps in the numbers.
    """

"""Entry to edges over Zenoh; import it only if there are such edges, for Zenoh is heavy."""

from followspot.transport.zenoh.network import LOOPBACK, Network
from followspot.transport.zenoh.reader import ZenohReader
from followspot.transport.zenoh.session import close_session, connected, locators, open_session
from followspot.transport.zenoh.writer import ZenohWriter

__all__ = [
    "LOOPBACK",
    "Network",
    "ZenohReader",
    "ZenohWriter",
    "close_session",
    "connected",
    "locators",
    "open_session",
]

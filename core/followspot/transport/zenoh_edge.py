"""The way in to edges over Zenoh; to be imported only where there are such edges, for Zenoh is heavy."""

from followspot.transport.zenoh_network import LOOPBACK, Network
from followspot.transport.zenoh_reader import ZenohReader
from followspot.transport.zenoh_session import close_session, connected, locators, open_session
from followspot.transport.zenoh_writer import ZenohWriter

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

"""Taps at ports of a run that has begun, which send to this process from every host."""

from __future__ import annotations

import threading
from collections.abc import Collection
from typing import Any

from followspot.control.tapping import Tapping
from followspot.errors import FollowspotError
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.operator.run_handle import RunHandle
from followspot.taps.receivers import Consume, LocalReceiver, RemoteReceiver, tap_key


class RunTaps:
    """Taps of one kind at ports (STAGE.PORT) of a run.

    uses: the tap, with the parameters `socket` and `port`; params: its other parameters; consume: takes the
    records of one sender in a thread of its own.
    """

    def __init__(
        self, run: RunHandle, ports: Collection[str], uses: str, consume: Consume, **params: Any
    ) -> None:
        """Raises FollowspotError if a port cannot be reached from here."""
        self._run = run
        self._ports, self._uses, self._params, self._consume = ports, uses, params, consume
        self._metadata = run.metadata()
        self._homes: dict[str, str] = {}
        self._taps: list[Tapping] = []
        self._folder = TemporaryFolder("tap")
        self._path = self._folder.path / "taps"
        self._local = LocalReceiver(self._path, consume)
        self._remote: list[RemoteReceiver] = []
        self._closed = False
        self._lock = threading.Lock()
        try:
            self.follow()
        except BaseException:
            self.close()
            raise

    def follow(self, ports: Collection[str] | None = None) -> None:
        """Tap the ports on the present hosts of their stages. Raises FollowspotError.

        ports: from now on, instead of those before.

        A stage that has left with a swap is tapped again if it comes back.
        """
        self._ports = self._ports if ports is None else ports
        plan = self._run.plan()
        present = {stage.name for stage in plan.stages}
        stages = {name: name.rpartition(".")[0] for name in self._ports}
        homes = {name: plan.host_of_stage(stage) for name, stage in stages.items() if stage in present}
        if (near := [name for name, host in homes.items() if not host]) and self._metadata.out is None:
            raise FollowspotError(f"{', '.join(near)}: on the operator's host; subscribe there")
        moved = {name: host for name, host in homes.items() if self._homes.get(name) != host}
        if moved:
            self._receive({name: host for name, host in moved.items() if host})
            taps = [self._tapping(name, host) for name, host in moved.items()]
            self._run.tap(taps)
            self._taps += [tap for tap in taps if tap not in self._taps]
        self._homes = homes

    def close(self, timeout: float = 0.0) -> bool:
        """Remove the taps and their receivers; False if that was done before.

        timeout: seconds for the last messages of this host to arrive.
        """
        with self._lock:
            if self._closed:
                return False
            self._closed = True
        if self._taps:
            self._run.untap(self._taps)
        for receiver in self._remote:  # also those of hosts that a stage has left: some was under way
            receiver.close()
        self._local.close(timeout)
        self._folder.close()
        return True

    def _receive(self, homes: dict[str, str]) -> None:
        """Subscribe to taps on other hosts, before they are placed."""
        keys = {name: tap_key(self._run.run, host, name, self._uses) for name, host in homes.items()}
        network = self._metadata.network
        with self._lock:
            if keys and network is not None and not self._closed:
                self._remote.append(RemoteReceiver(network, keys, self._consume))

    def _tapping(self, name: str, host: str) -> Tapping:
        place: dict[str, Any] = {} if host else {"socket": str(self._path)}
        return Tapping(name, self._uses, {**self._params, **place, "port": name})

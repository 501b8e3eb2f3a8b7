"""The silent hosts of a run: those that do not answer, with the reasons."""

from __future__ import annotations

from collections.abc import Iterable

from followspot.control.host import Host, HostLost
from followspot.operator.run_events import RunEvents


class SilentHosts:
    """Attends the hosts of a run, and logs when one falls silent and when it is back.

    reasons: why each silent host does not answer, as far as it is known, by name.
    """

    def __init__(self, events: RunEvents) -> None:
        self.reasons: dict[str, str] = {}
        self._events = events

    def __contains__(self, host: Host) -> bool:
        return host.name in self.reasons

    def attend(self, host: Host, timeout: float) -> None:
        """Attend a host for up to `timeout`, s; log that it falls silent, or that it is back."""
        try:
            host.attend(timeout)
        except HostLost as error:
            if host not in self:
                self._events.add(str(error), "warning")
            self.reasons[host.name] = str(error)
        else:
            if self.reasons.pop(host.name, None):
                self._events.add(f"host {host.name} is back", "info")

    def renew(self, hosts: Iterable[Host]) -> None:
        """Update the reasons: a host may have lost the run since it was attended last."""
        for host in hosts:
            try:
                host.attend(0.0)
            except HostLost as error:
                self.reasons[host.name] = str(error)

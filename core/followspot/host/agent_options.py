"""Options of an agent, which the owner of its host sets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from followspot.control.plan_transfer import unpacked
from followspot.host.operator_timeout import OPERATOR_TIMEOUT
from followspot.security.grants import Grants
from followspot.transport.zenoh.network import Network


@dataclass(frozen=True)
class AgentOptions:
    """Options of an agent.

    name: of the host, as rooms and placements use it; grants: files, receivers and devices that stages may
    use; runs: folder below which each run gets an output folder; plugin_files: one-file plugins installed
    here; clock_offset: known delay of this host's clock, ns; operator_timeout: seconds without a request of
    its operator after which a run that is not detached ends here.
    """

    name: str
    network: Network = Network()
    grants: Grants = Grants()
    runs: Path = Path("runs")
    plugin_files: tuple[str, ...] = ()
    clock_offset: int = 0
    operator_timeout: float = OPERATOR_TIMEOUT

    def unpacked(self, plan: dict[str, Any]) -> dict[str, Any]:
        """A plan as this host runs it. Raises FollowspotError if it uses anything that is not granted."""
        return unpacked(plan, self.name, self.grants, self.plugin_files)

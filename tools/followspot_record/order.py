"""What a recorder outside is told to record."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data, plan_to_data


@dataclass(frozen=True)
class Order:
    """plan: of the run; ports: STAGE.PORT each; path: of the file; listen: socket that taps send to."""

    plan: Plan
    ports: tuple[str, ...]
    path: Path
    listen: Path

    def to_line(self) -> str:
        """As standard input takes it."""
        plan = plan_to_data(self.plan)
        return json.dumps({**asdict(self), "plan": plan, "path": str(self.path), "listen": str(self.listen)})


def order_from_line(line: str) -> Order:
    """What `to_line` made."""
    data = json.loads(line)
    plan = plan_from_data(data["plan"])
    return Order(plan, tuple(data["ports"]), Path(data["path"]), Path(data["listen"]))

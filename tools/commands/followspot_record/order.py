"""What a recorder outside is told to record."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data, plan_to_data


@dataclass(frozen=True)
class Order:
    """plan: of the run; ports: STAGE.PORT each; path: of the file; listen: socket that taps here send to.

    far: keys of Zenoh that taps on other hosts send to, by port; network: leads there.
    """

    plan: Plan
    ports: tuple[str, ...]
    path: Path
    listen: Path
    far: Mapping[str, str] = field(default_factory=dict)
    network: Mapping[str, Any] | None = None

    def to_line(self) -> str:
        """As standard input takes it."""
        data = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return json.dumps({**data, "plan": plan_to_data(self.plan)}, default=str)


def order_from_line(line: str) -> Order:
    """What `to_line` made."""
    data = json.loads(line)
    places = {name: Path(data[name]) for name in ("path", "listen")}
    return Order(**{**data, **places, "plan": plan_from_data(data["plan"]), "ports": tuple(data["ports"])})

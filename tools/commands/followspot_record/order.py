"""The order that a recorder process reads from its standard input, as JSON."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import pydantic

from followspot import Network
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data


def _plan(given: Any) -> Plan:
    return given if isinstance(given, Plan) else plan_from_data(given)


class Order(pydantic.BaseModel, frozen=True):
    """plan: of the run; ports: STAGE.PORT each, and firings; path: of the file.

    listen: socket that taps here send to; remote: keys of Zenoh that taps on other hosts send to, by port;
    network: leads there.
    """

    plan: Annotated[Plan, pydantic.PlainValidator(_plan), pydantic.PlainSerializer(plan_to_data)]
    ports: tuple[str, ...]
    path: Path
    listen: Path
    remote: Mapping[str, str] = {}
    network: Network | None = None

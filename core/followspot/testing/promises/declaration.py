"""Promises about the declaration of a stage."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from importlib import import_module
from operator import attrgetter

import pydantic

from followspot.stage import Stage
from followspot.testing.trial import Trial, reason


def is_documented(trial: Trial) -> Iterator[str]:
    """The docstring is what `followspot plugins NAME` shows."""
    text = trial.stage.__doc__
    if not (text or "").strip() or text == Stage.__doc__:
        yield "write a docstring that says what the stage does"


def has_readable_ports(trial: Trial) -> Iterator[str]:
    """Ports are read from the signature of `process`; a source is a generator."""
    if trial.ports.source and not inspect.isgeneratorfunction(trial.stage.process):
        yield "process returns Source[...] and does not yield"


def is_found_by_its_name(trial: Trial) -> Iterator[str]:
    """A worker is a fresh process: it imports the stage by module and name."""
    stage = trial.stage
    try:
        found = attrgetter(stage.__qualname__)(import_module(stage.__module__))
    except (ImportError, AttributeError):
        found = None
    if found is not stage:
        yield f"{stage.__module__}:{stage.__qualname__} is not this class; define it at the top of a module"


def describes_its_parameters(trial: Trial) -> Iterator[str]:
    """Every parameter has a description."""
    for name, field in trial.stage.Params.model_fields.items():
        if not field.description:
            yield f"parameter {name} has no description"


def states_its_units(trial: Trial) -> Iterator[str]:
    """Every number says its unit."""
    for name, field in trial.stage.Params.model_fields.items():
        extra = field.json_schema_extra
        unit = extra.get("unit") if isinstance(extra, dict) else None
        if field.annotation in (int, float) and not unit:
            yield f'parameter {name} has no unit; write unit="1" for a plain number'


def has_defaults_within_its_limits(trial: Trial) -> Iterator[str]:
    """A stage whose parameters all have defaults can be built without parameters."""
    if not trial.complete:
        return
    try:
        trial.stage.Params(**trial.params)
    except pydantic.ValidationError as error:
        yield f"the defaults are refused: {reason(error)}"


def refuses_unknown_parameters(trial: Trial) -> Iterator[str]:
    """A misspelt parameter is an error, never ignored."""
    if trial.stage.Params.model_config.get("extra") != "forbid":
        yield "derive Params from followspot.StageParams"


def keeps_its_parameters(trial: Trial) -> Iterator[str]:
    """Parameters change by a new instance only, so that the shown values are those in use."""
    if not trial.stage.Params.model_config.get("frozen"):
        yield "derive Params from followspot.StageParams, which is frozen"


def takes_its_parameters_back(trial: Trial) -> Iterator[str]:
    """Parameters travel to a worker as JSON and mean the same there."""
    if not trial.buildable:
        return
    try:
        made = trial.stage.Params(**trial.params)
        sent = json.loads(json.dumps(made.model_dump(mode="json")))
        if trial.stage.Params(**sent).model_dump(mode="json") != sent:
            yield "other parameters come back from JSON than went in"
    except pydantic.ValidationError:
        return  # has_defaults_within_its_limits says so
    except (TypeError, ValueError) as error:
        yield f"the parameters do not become JSON: {reason(error)}"

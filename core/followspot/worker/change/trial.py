"""The stages that a plan adds to a worker, set up and closed again beside those that work: can they begin?"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedStage
from followspot.worker.build import Builder
from followspot.worker.change.rewiring import is_same
from followspot.worker.runners.stage_runner import StageRunner


def try_out(builder: Builder, present: Mapping[str, StageRunner]) -> None:
    """Set up what comes or changes, sources aside, whose devices may be in use. In any thread.

    builder: of the new plan; present: the stage runners that work. Raises FollowspotError with the reason.
    """
    for planned in builder.mine:
        runner = present.get(planned.name)
        if not (builder.wiring.ports[planned.name].source or (runner and is_same(runner, planned))):
            _try(builder, planned)


def _try(builder: Builder, planned: PlannedStage) -> None:
    stage = None
    try:
        stage = builder.wiring.classes[planned.name](builder.context(planned), **planned.params)
        stage.setup()
    except Exception as error:
        reason = str(error) if isinstance(error, FollowspotError) else f"{type(error).__name__}: {error}"
        raise FollowspotError(f"stage {planned.name} ({planned.uses}) cannot be built: {reason}") from error
    finally:
        if stage is not None:
            with suppress(Exception):  # it will be built anew
                stage.close()

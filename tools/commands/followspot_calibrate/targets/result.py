"""The results of all clips of targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from followspot_calibrate.targets.cameras import Agreement
from followspot_calibrate.targets.learning import Learnt
from followspot_calibrate.targets.separability import Separability


@dataclass(frozen=True, eq=False)
class TargetsResult:
    """The templates learnt by target, separability in colour cameras, and corrections of the cameras."""

    learnt: Mapping[str, Sequence[Learnt]]
    apart: Sequence[Separability]
    agreement: Agreement

    @property
    def warnings(self) -> list[str]:
        """Warnings beyond those about single clips."""
        problem = self.agreement.problem
        return [text for one in self.apart for text in one.warnings] + ([problem] if problem else [])

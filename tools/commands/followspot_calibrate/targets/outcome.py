"""What the clips of targets taught, all together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from followspot_calibrate.targets.cameras import Agreement
from followspot_calibrate.targets.learning import Lesson
from followspot_calibrate.targets.separability import Separability


@dataclass(frozen=True, eq=False)
class Outcome:
    """Lessons by target, how well colour cameras tell targets apart, and what became of the cameras."""

    lessons: Mapping[str, Sequence[Lesson]]
    apart: Sequence[Separability]
    agreement: Agreement

    @property
    def warnings(self) -> list[str]:
        """What the user should know, besides clips that taught nothing."""
        problem = self.agreement.problem
        return [text for one in self.apart for text in one.warnings] + ([problem] if problem else [])

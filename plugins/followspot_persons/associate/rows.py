"""Arrays that belong together, one row for each body."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Rows:
    """Base of tables of bodies: every field has one row for each."""

    def where(self, keep: Array) -> Self:
        """Only these rows: a mask or row numbers."""
        return type(self)(*(getattr(self, field.name)[keep] for field in fields(self)))

    def joined(self, other: Self) -> Self:
        """These rows, then the others."""
        pairs = [(getattr(self, f.name), getattr(other, f.name)) for f in fields(self)]
        return type(self)(*(np.concatenate(pair) for pair in pairs))

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

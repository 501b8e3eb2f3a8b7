"""`followspot shape`: read crops, fit, write, say how well it went."""

from __future__ import annotations

import argparse
import json
from typing import Any

from followspot.errors import require_unused
from followspot_persons.body.shape import SHIPPED, read_shape
from followspot_shape.crops import Crops, read_crops
from followspot_shape.fit import fitness, fitted_document, start_document
from followspot_shape.relate import relations_document
from followspot_shape.writing import COLOR_HEAD, SHAPE_HEAD, write


def make(args: argparse.Namespace) -> int:
    """Make the model that was asked for. Returns the exit code; raises InputError."""
    require_unused(args.out)
    crops = read_crops(args.crops)
    result = _fit(args, crops) if args.what == "fit" else _colors(args, crops)
    result = {"file": str(args.out), "crops": len(crops.body), **result}
    print(json.dumps(result) if args.json else "\n".join(f"{k}: {v}" for k, v in result.items()))
    return 0


def _fit(args: argparse.Namespace, crops: Crops) -> dict[str, Any]:
    document = fitted_document(crops)
    write(args.out, SHAPE_HEAD, document)
    return {
        "edge likelihood before": round(fitness(start_document(), crops), 4),
        "edge likelihood": round(fitness(document, crops), 4),
    }


def _colors(args: argparse.Namespace, crops: Crops) -> dict[str, Any]:
    document = relations_document(read_shape(args.shape or SHIPPED), crops)
    write(args.out, COLOR_HEAD, document)
    return {"features": len(document["features"])}

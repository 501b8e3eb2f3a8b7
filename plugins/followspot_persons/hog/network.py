"""A small network that judges windows: one hidden layer of rectified units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Network:
    """Weights of D inputs, K units and O outputs, f4."""

    hidden: Array
    """(D, K)"""
    hidden_bias: Array
    """(K,)"""
    output: Array
    """(K, O)"""
    output_bias: Array
    """(O,)"""


def outputs(network: Network, inputs: Array) -> Array:
    """What the network says of windows: (N, D) f4 -> (N, O)."""
    hidden = np.maximum(inputs @ network.hidden + network.hidden_bias, 0)
    return np.asarray(hidden @ network.output + network.output_bias)


def check(network: Network, inputs: int, outputs: int) -> None:
    """Raises ValueError if a shape does not fit so many inputs and outputs, or a number is not finite."""
    units = network.hidden_bias.size
    shapes = {
        "hidden": (inputs, units),
        "hidden_bias": (units,),
        "output": (units, outputs),
        "output_bias": (outputs,),
    }
    for name, shape in shapes.items():
        array = getattr(network, name)
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}, not {shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds numbers that are not finite")

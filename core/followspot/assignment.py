"""The assignment of most gain: each row to at most one column, each column to at most one row."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def assigned(gain: Array) -> tuple[Array, Array]:
    """Rows and columns, (K,) each, of the pairs with the largest sum of gains; rows ascend.

    gain: (N, M); a pair whose gain is not above 0 stays apart, -inf and NaN included. Hungarian method by
    shortest augmenting paths (Jonker & Volgenant 1987).
    """
    worth = np.where(gain > 0, gain, 0.0)
    rows, columns = np.flatnonzero(worth.any(axis=1)), np.flatnonzero(worth.any(axis=0))
    worth = worth[np.ix_(rows, columns)]
    if worth.size == 0:
        return np.zeros(0, int), np.zeros(0, int)
    if len(rows) <= len(columns):
        row_of = _matched(-worth)
        column = np.flatnonzero(row_of >= 0)
        row = row_of[column]
    else:
        column_of = _matched(-worth.T)
        row = np.flatnonzero(column_of >= 0)
        column = column_of[row]
    paid = worth[row, column] > 0
    row, column = rows[row[paid]], columns[column[paid]]
    order = np.argsort(row, kind="stable")
    return row[order], column[order]


def _matched(cost: Array) -> Array:
    """The row of each column, -1 for none, in the cheapest assignment of all rows. cost: (N, M), N <= M."""
    rows, columns = cost.shape
    u, v = np.zeros(rows + 1), np.zeros(columns + 1)
    match = np.zeros(columns + 1, int)  # row + 1 of column - 1; column 0 starts a path
    for row in range(1, rows + 1):
        match[0], column = row, 0
        least, before = np.full(columns + 1, np.inf), np.zeros(columns + 1, int)
        visited = np.zeros(columns + 1, bool)
        while True:
            visited[column] = True
            reduced = cost[match[column] - 1] - u[match[column]] - v[1:]
            better = ~visited[1:] & (reduced < least[1:])
            least[1:][better], before[1:][better] = reduced[better], column
            following = int(np.where(visited, np.inf, least)[1:].argmin()) + 1
            step = least[following]
            u[match[visited]] += step
            v[visited] -= step
            least[~visited] -= step
            column = following
            if match[column] == 0:
                break
        while column:
            match[column], column = match[before[column]], int(before[column])
    return match[1:] - 1

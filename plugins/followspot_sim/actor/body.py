"""The bodies of actors: a skeleton of nine joints, the tubes around it, and how people differ in shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.actor.mesh import Mesh, join, tube, wrap

PELVIS, CHEST, HEAD = 0, 1, 2
UPPER_ARM, FOREARM, THIGH, SHIN = (3, 4), (5, 6), (7, 8), (9, 10)
"""Bones, left before right; hands and feet belong to the forearms and shins."""
PARENT = (-1, 0, 1, 1, 1, 3, 4, 0, 0, 7, 8)
STATURE = 1.75
"""Of the rest pose with flat hair, m; proportions after adults of anthropometric tables."""
SHOULDER, HIP, HAND = 0.19, 0.09, 0.245
"""Distance of joints, and of the hanging hand, from the middle, m."""
PIVOT = np.array(
    [
        *([0.0, 0.0, 0.94], [0.0, 0.0, 1.06], [0.03, 0.0, 1.575]),
        *([0.0, SHOULDER, 1.40], [0.0, -SHOULDER, 1.40], [-0.01, 0.215, 1.12], [-0.01, -0.215, 1.12]),
        *([0.0, HIP, 0.92], [0.0, -HIP, 0.92], [0.0, 0.095, 0.50], [0.0, -0.095, 0.50]),
    ]
)
"""Joints in the rest pose, (11, 3) m."""
TORSO, NECK, SKULL, HAIR, ARM, LEG, FOOT = range(7)
"""Regions of the surface."""
WAIST, ELBOW = 1.0, 1.1
"""Heights where the upper body and the upper arms begin in the rest pose, m."""


@dataclass(frozen=True)
class Build:
    """How one person's shape differs from the others'."""

    stature: float
    """With hair, m."""
    girth: float
    """Width and depth of the body over the usual."""
    bust: float
    """By how much the chest stands out, m."""
    hair: str
    """short | bob | long | bun."""


@dataclass(frozen=True, eq=False)
class Body:
    """A person's surface in the rest pose.

    region: (F,) of each face; upper: (F,) whether it belongs to the upper body (without forearms and hands);
    top: vertices that may be the highest; scale: of the rest pose to the person.
    """

    mesh: Mesh
    region: Array
    upper: Array
    top: Array
    scale: float


def body_of(build: Build) -> Body:
    """The surface of a person: about 2,000 faces of 2 to 4 cm."""
    meshes = [
        (TORSO, _torso(build)),
        (NECK, _neck()),
        (SKULL, _skull()),
        *((HAIR, mesh) for mesh in _hair(build.hair)),
        *((ARM, _arm(side, build.girth)) for side in (0, 1)),
        *((LEG, _leg(side, build.girth)) for side in (0, 1)),
        *((FOOT, _foot(side)) for side in (0, 1)),
    ]
    mesh = join([each for _, each in meshes])
    region = np.concatenate([np.full(len(each.face), name) for name, each in meshes])
    top = np.unique(mesh.face[np.isin(region, (SKULL, HAIR))])
    height = mesh.centre()[:, 2]
    upper = (height > WAIST) & ((region != ARM) | (height > ELBOW))
    return Body(mesh, region, upper, top, build.stature / float(mesh.vertex[top, 2].max()))


def _torso(build: Build) -> Mesh:
    g, bust = build.girth, build.bust
    keys = [
        (0.85, 0.000, 0, 0.14 * g, 0.09 * g, 0.10 * g),
        (0.89, 0.000, 0, 0.176 * g, 0.112 * g, 0.124 * g),
        (0.95, 0.000, 0, 0.176 * g, 0.115 * g, 0.128 * g),
        (1.03, 0.000, 0, 0.166 * g, 0.115 * g, 0.108 * g),
        (1.10, 0.000, 0, 0.153 * g, 0.112 * g, 0.095 * g),
        (1.20, 0.000, 0, 0.158 * g, 0.116 * g + bust * 0.5, 0.098 * g),
        (1.30, 0.000, 0, 0.172 * g, 0.122 * g + bust, 0.112 * g),
        (1.37, -0.004, 0, 0.184 * g, 0.112 * g + bust * 0.5, 0.122 * g),
        (1.41, -0.008, 0, 0.190, 0.096, 0.112),
        (1.44, -0.010, 0, 0.176, 0.082, 0.096),
        (1.47, -0.010, 0, 0.138, 0.072, 0.082),
        (1.49, -0.008, 0, 0.092, 0.064, 0.070),
        (1.51, -0.004, 0, 0.066, 0.056, 0.060),
    ]
    return wrap(tube(keys, (PELVIS, CHEST), [(0.96, 1.16)], 28), 32, roundness=0.86)


def _neck() -> Mesh:
    keys = [(1.46, -0.01, 0, 0.064, 0.05, 0.06), (1.53, 0.006, 0, 0.056, 0.055, 0.055),
            (1.63, 0.03, 0, 0.056, 0.05, 0.06)]  # fmt: skip
    return wrap(tube(keys, (CHEST, HEAD), [(1.5, 1.6)], 7), 16)


SKULL_KEYS = [
    (1.522, 0.085, 0, 0.016, 0.022, 0.03),
    (1.535, 0.068, 0, 0.040, 0.062, 0.05),
    (1.565, 0.052, 0, 0.058, 0.082, 0.07),
    (1.600, 0.048, 0, 0.067, 0.088, 0.09),
    (1.640, 0.048, 0, 0.073, 0.089, 0.104),
    (1.670, 0.048, 0, 0.075, 0.088, 0.108),
    (1.700, 0.046, 0, 0.072, 0.080, 0.100),
    (1.722, 0.044, 0, 0.056, 0.062, 0.080),
    (1.735, 0.042, 0, 0.030, 0.034, 0.044),
]
"""Rings of the head without hair; z, x, y, half width, half depth to front and back, m."""


def _skull() -> Mesh:
    mesh = wrap(tube(SKULL_KEYS, (HEAD,), (), 20), 28, roundness=0.94)
    x, y, z = mesh.vertex.T
    front = (x > 0.1) * np.exp(-((y / 0.014) ** 2))
    nose = front * 0.026 * np.interp(z, [1.585, 1.596, 1.635], [0.0, 1.0, 0.0])
    brow = (x > 0.1) * 0.006 * np.exp(-(((z - 1.648) / 0.01) ** 2))
    sockets = -0.008 * (x > 0.1) * np.exp(-(((np.abs(y) - 0.032) / 0.014) ** 2) - ((z - 1.63) / 0.01) ** 2)
    moved = mesh.vertex + np.column_stack([nose + brow + sockets, 0 * x, 0 * x])
    ears = [_ear(side) for side in (1, -1)]
    return join([Mesh(moved, mesh.bone, mesh.weight, mesh.face), *ears])


def _ear(side: int) -> Mesh:
    keys = [
        (1.592, 0.038, side * 0.070, 0.006, 0.010, 0.010),
        (1.62, 0.034, side * 0.076, 0.010, 0.018, 0.018),
        (1.65, 0.030, side * 0.078, 0.010, 0.018, 0.020),
    ]
    return wrap(tube(keys, (HEAD,), (), 4), 8)


def _hair(style: str) -> list[Mesh]:
    """Hair: a cap over the skull, with a tail or a bun."""
    cap = [(z, x - 0.004, y, w + 0.013, f + 0.004, b + 0.017) for z, x, y, w, f, b in SKULL_KEYS[3:]]
    cap.append((1.75, 0.038, 0, 0.022, 0.026, 0.032))
    found = [_open_face(wrap(tube(cap, (HEAD,), (), 14), 28))]
    if style == "bun":
        knot = [(1.64, -0.10, 0, 0.02, 0.02, 0.02), (1.67, -0.105, 0, 0.042, 0.03, 0.045),
                (1.71, -0.10, 0, 0.035, 0.03, 0.035), (1.73, -0.09, 0, 0.01, 0.01, 0.01)]  # fmt: skip
        found.append(wrap(tube(knot, (HEAD,), (), 7), 12))
    if style in ("bob", "long"):
        end = 1.535 if style == "bob" else 1.40
        hang = [(end, -0.035, 0, 0.075, 0.05, 0.05), (1.60, 0.0, 0, 0.088, 0.03, 0.082),
                (1.66, 0.01, 0, 0.086, 0.03, 0.088)]  # fmt: skip
        found.append(wrap(tube(hang, (CHEST, HEAD), [(1.36, 1.60)], 12), 20))
    return found


def _open_face(cap: Mesh) -> Mesh:
    """Hair ends at the forehead, at the temples, and above the ears and the neck."""
    x, _, z = cap.centre().T
    return Mesh(cap.vertex, cap.bone, cap.weight, cap.face[z > hairline(x)])


def hairline(x: Array) -> Array:
    """Height at which hair begins, x m in front of the middle in the rest pose, m."""
    return np.interp(x, [-0.03, 0.0, 0.05, 0.09, 0.12], [1.60, 1.645, 1.655, 1.69, 1.70])


def _arm(side: int, girth: float) -> Mesh:
    s, g = 1 - 2 * side, 0.6 + 0.4 * girth
    keys = [
        (0.67, 0.020, s * HAND, 0.008, 0.015, 0.015),
        (0.70, 0.016, s * HAND, 0.018, 0.034, 0.030),
        (0.77, 0.008, s * HAND, 0.022, 0.044, 0.038),
        (0.84, 0.000, s * 0.24, 0.026, 0.032, 0.030),
        (0.88, 0.000, s * 0.235, 0.030 * g, 0.031 * g, 0.031 * g),
        (1.03, -0.006, s * 0.222, 0.043 * g, 0.045 * g, 0.045 * g),
        (1.12, -0.010, s * 0.215, 0.042 * g, 0.045 * g, 0.045 * g),
        (1.26, -0.006, s * 0.207, 0.050 * g, 0.055 * g, 0.055 * g),
        (1.36, -0.004, s * 0.196, 0.056 * g, 0.062 * g, 0.062 * g),
        (1.41, -0.004, s * 0.186, 0.050 * g, 0.056 * g, 0.056 * g),
        (1.44, -0.004, s * 0.172, 0.030 * g, 0.034 * g, 0.034 * g),
    ]
    bones = (FOREARM[side], UPPER_ARM[side], CHEST)
    return wrap(tube(keys, bones, [(1.07, 1.17), (1.35, 1.50)], 26), 12)


def _leg(side: int, girth: float) -> Mesh:
    s = 1 - 2 * side
    g = 0.5 + 0.5 * girth
    keys = [
        (0.06, -0.012, s * 0.10, 0.045, 0.05, 0.05),
        (0.12, -0.012, s * 0.10, 0.047, 0.05, 0.052),
        (0.33, -0.012, s * 0.098, 0.060 * g, 0.062 * g, 0.068 * g),
        (0.50, 0.0, s * 0.095, 0.062 * g, 0.068 * g, 0.062 * g),
        (0.70, 0.0, s * 0.092, 0.078 * g, 0.085 * g, 0.085 * g),
        (0.86, 0.0, s * 0.092, 0.088 * g, 0.098 * g, 0.105 * g),
        (0.95, 0.0, s * 0.085, 0.075 * g, 0.080 * g, 0.090 * g),
    ]
    bones = (SHIN[side], THIGH[side], PELVIS)
    return wrap(tube(keys, bones, [(0.44, 0.56), (0.80, 1.00)], 20), 12)


def _foot(side: int) -> Mesh:
    s = 1 - 2 * side
    keys = [
        (0.0, 0.05, s * 0.10, 0.045, 0.13, 0.11),
        (0.025, 0.05, s * 0.10, 0.048, 0.135, 0.115),
        (0.06, 0.02, s * 0.10, 0.046, 0.11, 0.09),
        (0.10, -0.01, s * 0.10, 0.044, 0.055, 0.06),
    ]
    return wrap(tube(keys, (SHIN[side],), (), 6), 14)

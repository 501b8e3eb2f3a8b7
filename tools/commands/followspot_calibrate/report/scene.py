"""The cameras of a room in 3D: frusta, names, planes, axes and points, as lines that a script can turn."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import cos, pi, radians, sin

import numpy as np

from followspot import Camera
from followspot.geometry import ray
from followspot.messages import Array
from followspot_calibrate.report.elements import Element, element
from followspot_calibrate.report.page import Section

WIDTH, HEIGHT = 1000, 560
YAW, PITCH = radians(-35.0), radians(28.0)
MOST_POINTS = 1200
FILLED = 1.0
"""Radius of the scene over the picture's half height."""
FRUSTUM = 0.12
"""Length of the frusta over the scene's radius."""
INK = {"color": "#2563c9", "infrared": "#7b3fa0"}
MARKED = "#cc3d3d"
PLANE_INK = "#c98a1b"
VIEWS = (("from an edge", "", ""), ("from above", 0.0, pi / 2), ("front", 0.0, 0.0), ("side", pi / 2, 0.0))

Lines = Sequence[Array]
"""Polylines in the room, (N, 3) m each."""


def poses(
    cameras: Sequence[Camera],
    planes: Mapping[str, Array] | None = None,
    points: Array | None = None,
    marked: Collection[str] = (),
) -> Section:
    """A drawing of the cameras and their viewing directions.

    planes: name -> (4,) m; points: (N, 3) m, of which some are drawn; marked: names of cameras to point out.
    """
    sampled = sample(points)
    center, radius = extent(np.array([c.center for c in cameras]).reshape(-1, 3), sampled)
    view = View(center, FILLED * HEIGHT / 2 / radius)
    shapes = [view.path(floor_grid(center, radius), "#e3e7ec", 1)]
    shapes += [view.path(lines, ink, 2) for lines, ink in axes(radius)]
    shapes += _plane_shapes(view, planes or {}, radius)
    shapes.append(view.path(list(sampled[:, None]), "#7b8896", 3))
    shapes += _camera_shapes(view, cameras, radius, marked)
    picture = element(
        "svg",
        *shapes,
        class_="scene",
        viewBox=f"0 0 {WIDTH} {HEIGHT}",
        role="img",
        data_width=WIDTH,
        data_height=HEIGHT,
        data_center=_triple(center),
        data_zoom=f"{view.zoom:.4f}",
        data_yaw=f"{YAW:.5f}",
        data_pitch=f"{PITCH:.5f}",
    )
    buttons = (
        element("button", name, type="button", data_yaw=yaw, data_pitch=pitch) for name, yaw, pitch in VIEWS
    )
    note = (
        "Color cameras blue, infrared cameras violet, planes ochre; axes x red, y green, z blue of 1 m; "
        "the grid is z = 0 in squares of 1 m. Drag to turn, scroll to zoom."
    )
    content = element("div", element("div", *buttons, class_="views"), picture)
    return Section("Cameras in the room", [content], note)


def _plane_shapes(view: View, planes: Mapping[str, Array], radius: float) -> Iterator[Element]:
    """A square of each plane and its name. radius: of the scene, m."""
    for number, (name, plane) in enumerate(planes.items()):
        patch = plane_patch(plane, view.center, radius * 0.5)
        yield view.path([patch], PLANE_INK, 1.5)
        yield view.label(patch[number % 4], name, PLANE_INK)


def _camera_shapes(
    view: View, cameras: Sequence[Camera], radius: float, marked: Collection[str]
) -> Iterator[Element]:
    """The frusta of the cameras, then their names, so that no line runs through these."""
    inks = [MARKED if camera.name in marked else INK[camera.kind] for camera in cameras]
    for camera, ink in zip(cameras, inks, strict=True):
        yield view.path(frustum(camera, FRUSTUM * radius), ink, 1.5)
    for camera, ink in zip(cameras, inks, strict=True):
        yield view.label(camera.center, camera.name, ink)


class View:
    """An orthographic view around a centre; zoom: px per m."""

    def __init__(self, center: Array, zoom: float) -> None:
        self.center, self.zoom = center, zoom

    def place(self, points: Array) -> Array:
        """(N, 3) m -> (N, 2) px; scene.js does the same."""
        x, y, z = (points - self.center).T
        across = cos(YAW) * x + sin(YAW) * y
        up = cos(PITCH) * z + sin(PITCH) * (cos(YAW) * y - sin(YAW) * x)
        return np.column_stack([WIDTH / 2 + self.zoom * across, HEIGHT / 2 - self.zoom * up])

    def path(self, lines: Lines, ink: str, width: float) -> Element:
        """Polylines of one colour; one point alone is a dot."""
        drawn = "".join(
            "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in self.place(line)) + ("" if len(line) > 1 else "h0")
            for line in lines
        )
        return element("path", d=drawn, stroke=ink, stroke_width=width, data_p=_packed(lines))

    def label(self, point: Array, text: str, ink: str) -> Element:
        """A name beside a point."""
        ((x, y),) = self.place(point[None])
        style = f"fill:{ink}"
        return element(
            "text", text, x=f"{x:.1f}", y=f"{y:.1f}", dx=8, dy=-10, style=style, data_p=_triple(point)
        )


def frustum(camera: Camera, length: float) -> list[Array]:
    """The pyramid of a camera's view, and a mark above its picture: polylines."""
    width, height = camera.size
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], float)
    if camera.model == "pinhole":
        homogeneous = np.column_stack([corners, np.ones(4)])
        rays = np.linalg.solve(camera.matrix, homogeneous.T).T @ camera.rotation
    else:
        rays = ray(camera, corners)
    a, b, c, d = camera.center + length * rays
    top = (a + b) / 2 + ((a + b) - (c + d)) * 0.15
    at = camera.center
    return [np.array([at, a, b, at]), np.array([at, d, c, at]), np.array([b, c]), np.array([a, d]),
            np.array([a, top, b])]  # fmt: skip


def plane_patch(plane: Array, center: Array, size: float) -> Array:
    """A square of a plane around the point that is nearest to the centre: (5, 3) m, closed."""
    normal = plane[:3]
    middle = center - (normal @ center + plane[3]) * normal
    across = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    return np.array([middle + size * (i * across + j * along)
                     for i, j in ((1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1))])  # fmt: skip


def floor_grid(center: Array, radius: float) -> list[Array]:
    """Lines on z = 0, 1 m apart; wider if the room is so large that they would run together."""
    step = 1.0 if radius < 30 else 10.0 ** np.ceil(np.log10(radius / 30))
    low, high = np.floor((center[:2] - radius) / step), np.ceil((center[:2] + radius) / step)
    (left, near), (right, far) = low * step, high * step
    lines = [np.array([[x, near, 0], [x, far, 0]]) for x in np.arange(left, right + step / 2, step)]
    return lines + [np.array([[left, y, 0], [right, y, 0]]) for y in np.arange(near, far + step / 2, step)]


def axes(radius: float) -> list[tuple[Lines, str]]:
    """The room's axes at its origin, 1 m long, or as long as the scene lets them be seen."""
    length = 1.0 if radius < 30 else radius / 10
    inks = ("#d33a3a", "#2a9d4a", "#2a62d3")
    return [
        ([np.array([np.zeros(3), length * axis])], ink) for axis, ink in zip(np.eye(3), inks, strict=True)
    ]


def extent(centers: Array, points: Array) -> tuple[Array, float]:
    """Middle and radius of what is to be seen, m."""
    seen = np.vstack([centers, points]) if len(points) else np.vstack([centers, np.zeros((1, 3))])
    low, high = np.percentile(points, [2, 98], axis=0) if len(points) else (seen.min(0), seen.max(0))
    low, high = np.minimum(low, centers.min(0)), np.maximum(high, centers.max(0))
    return (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-3)


def sample(points: Array | None) -> Array:
    """At most `MOST_POINTS` of the points, evenly taken."""
    if points is None:
        return np.empty((0, 3))
    known = points[np.isfinite(points).all(axis=1)]
    return np.asarray(known[:: max(1, -(-len(known) // MOST_POINTS))])


def _packed(lines: Lines) -> str:
    return ";".join(" ".join(_triple(point) for point in line) for line in lines)


def _triple(point: Array) -> str:
    return ",".join(f"{value:.3f}" for value in point)

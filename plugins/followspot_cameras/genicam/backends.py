"""The programs that speak to cameras, and the camera that a user means.

At least one of them must be installed for this module to be imported.
"""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from typing import Literal, cast

from followspot.errors import InputError, Mistake
from followspot_cameras.genicam.camera import Backend, CameraGone, CameraInfo, VisionCamera

BackendName = Literal["any", "viva-genicam", "aravis"]
_MODULES = {"viva-genicam": ("viva_genicam", "viva"), "aravis": ("gi", "aravis")}
"""The package that a backend needs, and its module here."""
REMEDIES = {
    "viva-genicam": "pip install 'followspot[genicam]'",
    "aravis": "install your distribution's gir1.2-aravis-0.8, and let Python see its package gi",
}
DISCOVERY = 0.5
"""Time that cameras have to answer, s."""


def backend(name: str) -> Backend | None:
    """The module of a backend; None if what it needs is not installed."""
    package, module = _MODULES[name]
    if find_spec(package) is None:
        return None
    try:
        return cast(Backend, importlib.import_module(f"followspot_cameras.genicam.{module}"))
    except (
        ImportError,
        ValueError,
        AttributeError,
    ):  # gi is there, and knows no Aravis, or is another package
        return None


def backends(name: BackendName = "any") -> list[Backend]:
    """The installed backends, or the one of that name if it is installed."""
    wanted = list(_MODULES) if name == "any" else [name]
    return [module for module in map(backend, wanted) if module is not None]


def discovered(
    name: BackendName = "any", interface: str = "", timeout: float = DISCOVERY
) -> list[CameraInfo]:
    """The cameras in sight, each once, by the first backend that sees it. timeout: s."""
    found: dict[tuple[str, str], CameraInfo] = {}
    for module in backends(name):
        for info in module.discover(interface, timeout):
            found.setdefault((info.transport, info.address), module.described(info))
    return list(found.values())


def connected(word: str, name: BackendName, interface: str, packet_size: int) -> VisionCamera:
    """The camera that a user means by a word. Raises InputError, CameraGone."""
    modules = backends(name)
    if not modules:
        text = f"the backend {name} is not installed"
        raise InputError([Mistake(None, text, REMEDIES.get(name, " or ".join(REMEDIES.values())))])
    seen: list[CameraInfo] = []
    for module in modules:
        cameras = module.discover(interface, DISCOVERY)
        meant = [info for info in cameras if not word or word in info.words]
        if word and not meant:  # serial numbers may be told only when asked for
            cameras = [module.described(info) for info in cameras]
            meant = [info for info in cameras if word in info.words]
        if len(meant) > 1:
            names = ", ".join(map(str, meant))
            text = f"{len(meant)} cameras are {f'called {word}' if word else 'in sight'}: {names}"
            raise InputError.of(text, "name one: camera: its serial number or its address")
        if meant:
            return module.connect(meant[0], interface, packet_size)
        seen += cameras
    for module in modules:
        found = module.addressed(word)
        if found is not None:
            return module.connect(found, interface, packet_size)
    told = ", ".join(map(str, seen)) or "none"
    raise CameraGone(f"it is not in sight; cameras in sight: {told}")


if not backends():
    importlib.import_module("viva_genicam")  # raises ModuleNotFoundError, which says what is not installed

"""A camera in a file of Qualisys, with attributes replaced."""

import re
from pathlib import Path

from tests.tools.exported import a_camera, back


def qualisys(folder: Path, **replacements: str) -> Path:
    back(folder, "qualisys", [a_camera()])
    file = folder / "x.qca.txt"
    text = file.read_text()
    for old, new in replacements.items():
        text = re.sub(f'{old}="[^"]*"', f'{old}="{new}"', text)
    file.write_text(text)
    return file

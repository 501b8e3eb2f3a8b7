"""Files may be written into the folder of a stage that writes a folder."""

from pathlib import Path

import followspot as fs

STAGES = """
  save: {uses: sinks.csv, in: {tracks: track}, with: {path: drawn/notes.csv}}
  draw: {uses: sinks.draw, in: {frames: camera}, with: {path: drawn}}
"""


def test_a_table_may_be_in_the_folder_of_drawn_pictures(tmp_path: Path) -> None:
    ready = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
    path = tmp_path / "graph.yaml"
    path.write_text(f"graph: g\nextends: {ready}\nstages:{STAGES}")
    assert [mistake for mistake in fs.check(path) if not mistake.warning] == []

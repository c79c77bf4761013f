from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.capture.layouts import load_layout
from mien.face.head_space import head_space
from mien.fit.mesh_markers import vertices_for


def test_markers_are_found_on_a_head_of_another_unit_and_turn(tmp_path: Path) -> None:
    skin = head_space().skin
    turned = skin.vertices[:, [2, 0, 1]] * 0.001  # metres, another axis up
    lines = ["v {:.6f} {:.6f} {:.6f}".format(*row) for row in turned]
    (tmp_path / "head.obj").write_text("\n".join(lines + ["f {} {} {}".format(*(row + 1)) for row in skin.triangles]))
    layout = load_layout("face-102")
    found = vertices_for(tmp_path / "head.obj", turned, "face-102")
    distance = [np.linalg.norm(skin.vertices[found[name]] - layout.place(name)) for name in layout.markers]
    assert np.median(distance) < 2
    assert max(distance) < 5

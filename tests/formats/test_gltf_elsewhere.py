"""Our GLBs read by Babylon.js and by glTF-Transform: the same weights, whole, compact and compressed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from mien.core.channels import ARKIT
from mien.face.library import load_face
from mien.formats.gltf import write_glb
from mien.formats.livelink import arkit_weights
from tests import node
from tests.faces import tiny_animation

pytestmark = pytest.mark.slow

STYLES = {"whole": {}, "compact": {"compact": True}, "meshopt": {"meshopt": True}}


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """What the two libraries made of each file."""
    folder, animation = tmp_path_factory.mktemp("glb"), tiny_animation(4)
    for name, style in STYLES.items():
        write_glb(animation, load_face(), folder / f"{name}.glb", clip="talk", **style)
    checks = node.installed("tests/viewer_check")
    said = node.run("node", "others.mjs", *(str(folder / f"{name}.glb") for name in STYLES), folder=checks)
    lines = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
    return animation.channels, dict(zip(STYLES, lines, strict=True))


# Babylon.js fetches its decoder of compressed files from the network.
@pytest.mark.parametrize(
    ("style", "library"), [("whole", "babylon"), ("compact", "babylon"), *((style, "transform") for style in STYLES)]
)
def test_the_last_keys_weights(read, style, library):
    track, found = read
    weights = found[style][library]["weights"]
    plain = style == "whole"
    assert found[style][library]["clips"] == ["talk"]
    assert plain or list(weights) == list(ARKIT)
    wanted = track.select(ARKIT).values[-1] if plain else arkit_weights(track)[-1]
    np.testing.assert_allclose([weights[name] for name in ARKIT], wanted, atol=1e-4)


@pytest.mark.parametrize("style", ["compact", "meshopt"])
def test_targets_move_as_far_as_they_did(read, style):
    _, found = read
    whole, small = found["whole"]["transform"]["moved"], found[style]["transform"]["moved"]
    jaw = small["jawOpen"] / whole["jawOpen"]  # steps of the file in a metre
    for name in ARKIT:
        # Steps of 0.05 mm; the vertex that moves most need not be one of those kept.
        assert small[name] / jaw == pytest.approx(whole[name], abs=2e-4), name

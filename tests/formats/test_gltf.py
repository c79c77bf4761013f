"""The GLB says the same as our own posing, and is what the format asks for."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mien.core.channels import ALL, ARKIT, MUSCLES, TONGUE
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.formats.gltf import write_glb
from tests.faces import tiny_animation, tiny_face
from tests.formats.glb_reader import Glb


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("glb") / "tiny.glb"
    animation, face = tiny_animation(), tiny_face()
    assert write_glb(animation, face, path) == ()
    return animation, face, Glb(path), path


def assert_agrees_with_poser(animation, face, glb, frame) -> None:
    """Every vertex within a hundredth of a millimetre of `Poser`."""
    posed = Poser(face, animation.channels.names).pose(animation.channels.values[frame])
    eyes = {eye.part: f"eye_{eye.side.lower()}" for eye in face.eyes}
    groups = {
        "face": [p.name for p in face.parts if p.name not in eyes and not set(p.targets) & set(TONGUE)],
        "tongue": [p.name for p in face.parts if set(p.targets) & set(TONGUE)],
    } | {node: [part] for part, node in eyes.items()}
    checked = 0
    for node, names in groups.items():
        if not names:
            continue
        for name, points in zip(names, glb.vertices(node, frame), strict=True):
            number = [part.name for part in face.parts].index(name)
            difference = np.linalg.norm(points * 1000 - posed.parts[number].vertices, axis=1)
            assert difference.max() < 0.01, (name, difference.max())
            checked += 1
    assert checked == len(face.parts)


@pytest.mark.parametrize("frame", [0, 7, 29])
def test_vertices_agree_with_poser(written, frame):
    animation, face, glb, _ = written
    assert_agrees_with_poser(animation, face, glb, frame)


def test_target_names(written):
    glb = written[2].gltf
    meshes = {mesh.name: mesh for mesh in glb.meshes}
    assert meshes["face"].extras["targetNames"] == list(ARKIT + MUSCLES)
    assert meshes["tongue"].extras["targetNames"] == list(ARKIT + TONGUE)
    assert all(len(primitive.targets) == 52 + len(MUSCLES) for primitive in meshes["face"].primitives)


def test_times_are_exact(written):
    animation, _, glb, _ = written
    times, weights = glb.track(glb.node("face"), "weights")
    assert np.array_equal(times, (np.arange(30) / 25).astype(np.float32))
    assert np.array_equal(weights, animation.channels.select(ARKIT + MUSCLES).values.astype(np.float32))
    facts = glb.gltf.animations[0].extras["mien"]
    assert facts["audioStartSeconds"] == 0.0
    assert facts["audioDurationSeconds"] == animation.utterance.duration
    assert facts["words"][0]["label"] == 'up "there"'


def test_rotations_take_the_short_way(tmp_path):
    animation = tiny_animation(200)
    values = animation.channels.values.copy()
    values[:, ALL.index("headYaw")] = np.linspace(-400, 400, 200)
    turning = replace(animation, channels=ChannelTrack(ALL, values, animation.rate))
    write_glb(turning, tiny_face(), tmp_path / "turn.glb")
    glb = Glb(tmp_path / "turn.glb")
    turns = glb.track(glb.node("head"), "rotation")[1]
    assert ((turns[1:] * turns[:-1]).sum(axis=1) > 0).all()
    assert np.allclose(np.linalg.norm(turns, axis=1), 1, atol=1e-6)


def test_morph_normals_follow_the_surface(written):
    """At weight 1 of one target, rest normal + change is the normal of the posed surface."""
    _, face, glb, _ = written
    primitive = glb.gltf.meshes[glb.gltf.nodes[glb.node("face")].mesh].primitives[0]
    column = ARKIT.index("jawOpen")
    target = primitive.targets[column]
    change = glb.array(target["NORMAL"] if isinstance(target, dict) else target.NORMAL)
    normals = glb.array(primitive.attributes.NORMAL) + change
    expected = Poser(face, ("jawOpen",)).pose([1.0]).parts[0].normals
    assert np.abs(change).max() > 0.2
    assert np.abs(normals - expected).max() < 0.01


def test_materials(written):
    _, face, glb, _ = written
    skin = glb.gltf.materials[[m.name for m in glb.gltf.materials].index("skin")]
    assert skin.pbrMetallicRoughness.roughnessFactor == 0.55
    assert skin.pbrMetallicRoughness.metallicFactor == 0.0
    picture = glb.gltf.images[0]
    place = glb.gltf.bufferViews[picture.bufferView]
    stored = np.asarray(Image.open(io.BytesIO(glb.blob[place.byteOffset : place.byteOffset + place.byteLength])))
    assert np.abs(stored.astype(int) - face.part("skin").material.texture).mean() < 4
    teeth = glb.gltf.meshes[glb.gltf.nodes[glb.node("face")].mesh].primitives[1]
    colours = glb.array(teeth.attributes.COLOR_0)  # linear light
    assert colours[-1] == pytest.approx([1, 1, 1, 1])
    assert colours[0, 0] == pytest.approx(((0.4 + 0.055) / 1.055) ** 2.4, abs=1e-4)


def test_container_is_well_formed(written):
    raw = written[3].read_bytes()
    magic, version, length, text_length, kind = struct.unpack("<4sIII4s", raw[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(raw), b"JSON")
    document = json.loads(raw[20 : 20 + text_length])
    assert all(view["byteOffset"] % 4 == 0 for view in document["bufferViews"])
    assert "extensionsUsed" not in document


def test_untouched_targets_take_no_bytes(written):
    glb = written[2]
    teeth = glb.gltf.meshes[glb.gltf.nodes[glb.node("face")].mesh].primitives[1]
    empty = {t["POSITION"] if isinstance(t, dict) else t.POSITION for t in teeth.targets}
    assert len(empty) == 2  # one shared zero accessor, and jawOpen


def test_no_frames(tmp_path):
    animation = tiny_animation()
    still = replace(animation, channels=ChannelTrack(ALL, np.zeros((0, len(ALL))), FrameRate.of(25)))
    with pytest.raises(InputError, match="no frames"):
        write_glb(still, tiny_face(), tmp_path / "none.glb")
    assert list(tmp_path.iterdir()) == []


def test_face_without_eyes_or_tongue(tmp_path):
    face = tiny_face()
    bald = type(face)(face.name, face.parts[:1], (), face.head_pivot, {}, "")
    write_glb(tiny_animation(), bald, tmp_path / "bald.glb")
    assert_agrees_with_poser(tiny_animation(), bald, Glb(tmp_path / "bald.glb"), 4)


def test_default_face_agrees_with_poser(tmp_path):
    animation, face = tiny_animation(6), load_face("default")
    write_glb(animation, face, tmp_path / "default.glb")
    assert_agrees_with_poser(animation, face, Glb(tmp_path / "default.glb"), 5)


def test_a_cut_out_texture_keeps_its_holes(tmp_path):
    animation, face = tiny_animation(), tiny_face()
    part = next(part for part in face.parts if part.material.texture is not None)
    texture = np.full((8, 8, 4), 200, np.uint8)
    texture[:4, :, 3] = 0
    cut = replace(part, material=replace(part.material, texture=texture))
    for compact in (False, True):
        write_glb(
            animation,
            replace(face, parts=tuple(cut if one is part else one for one in face.parts)),
            tmp_path / "a.glb",
            compact=compact,
        )
        gltf = Glb(tmp_path / "a.glb").gltf
        assert "image/png" in {image.mimeType for image in gltf.images}
        assert [material.alphaMode for material in gltf.materials].count("MASK") == 1

"""Compact GLBs show what the whole one shows: read by pygltflib and meshoptimizer's decoder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mien.cli import main
from mien.core.channels import ARKIT, HEAD
from mien.core.tracks import ChannelTrack
from mien.face.library import load_face
from mien.face.posing import Poser
from mien.formats.gltf import write_glb
from mien.formats.livelink import arkit_weights
from mien.formats.native import write_native
from mien.formats.reduced_meshes import reduced_face
from tests.faces import tiny_animation
from tests.formats.glb_reader import Glb

NODES = {"eye_left": ("eye_left",), "eye_right": ("eye_right",), "tongue": ("tongue",)}


@pytest.fixture(scope="module")
def animation():
    made = tiny_animation(6)
    values = 0.6 * made.channels.values
    return replace(made, channels=ChannelTrack(made.channels.names, values, made.rate))


@pytest.mark.parametrize("meshopt", [False, True])
def test_every_vertex_stands_within_a_tenth_of_a_millimetre(animation, meshopt, tmp_path):
    face = load_face()
    write_glb(animation, face, tmp_path / "a.glb", compact=True, meshopt=meshopt)
    glb, track = Glb(tmp_path / "a.glb"), animation.channels
    row = np.hstack([arkit_weights(track), track.select(HEAD).values])[4]
    posed = Poser(face, ARKIT + HEAD).pose(row)
    number = {part.name: k for k, part in enumerate(face.parts)}
    for node, names in NODES.items():
        (points,) = glb.vertices(node, 4)
        wanted = posed.parts[number[names[0]]].vertices
        assert cKDTree(wanted).query(1000 * points)[0].max() < 0.1
    skin = glb.vertices("face", 4)[0]
    wanted = posed.parts[number["skin"]].vertices
    # A target's least movements are left out, and many may be at work at once.
    assert cKDTree(wanted).query(1000 * skin)[0].max() < 0.5
    assert np.quantile(cKDTree(wanted).query(1000 * skin)[0], 0.99) < 0.2
    names = {mesh.name: mesh.extras.get("targetNames", []) for mesh in glb.gltf.meshes}
    assert len(names["face"]) <= 52


def test_how_large_they_are(animation, tmp_path):
    face, sizes = load_face(), {}
    for name in ("whole", "compact", "meshopt"):
        write_glb(animation, face, tmp_path / "a.glb", compact=name == "compact", meshopt=name == "meshopt")
        sizes[name] = (tmp_path / "a.glb").stat().st_size
    assert sizes["compact"] < 2.9e6  # four seconds of motion in three million bytes
    assert sizes["meshopt"] < 1.4e6


def test_the_meshes_of_the_face_are_known_and_a_strange_one_stays_as_it_is():
    face = load_face()
    reduced, numbers = reduced_face(face)
    for name in ("skin", "teeth_upper", "eye_left"):
        whole, part = face.part(name), reduced.part(name)
        assert len(part.triangles) < 0.6 * len(whole.triangles)
        assert np.array_equal(part.vertices, whole.vertices[numbers[name]])
        assert np.abs(part.vertices.max(0) - whole.vertices.max(0)).max() < 0.5
    strange = replace(face.part("skin"), triangles=face.part("skin").triangles[:-1])
    kept = reduced_face(replace(face, parts=(strange,), eyes=()))[0].parts[0]
    assert len(kept.triangles) == len(strange.triangles)


def test_the_clip_and_the_style_by_the_command_line(animation, tmp_path, capsys):
    write_native(animation, tmp_path / "a.json")
    express = ["express", str(tmp_path / "a.json"), "--compact"]
    assert main([*express, "--clip", "talk", "-o", str(tmp_path / "a.glb")]) == 0
    glb = Glb(tmp_path / "a.glb").gltf
    assert glb.animations[0].name == "talk"
    assert glb.extensionsRequired == ["KHR_mesh_quantization"]
    assert main([*express, "-o", str(tmp_path / "a.csv")]) == 2
    assert "are for a .glb" in capsys.readouterr().err

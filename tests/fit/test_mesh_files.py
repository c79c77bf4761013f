from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError
from mien.fit.mesh_files import read_mesh

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]], np.float32)
ASCII = """ply
format ascii 1.0
comment made by hand
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 1
property list uchar int vertex_indices
end_header
0 0 0 255 0 0
1 0 0 255 0 0
1 1 0 255 0 0
0 1 0.5 255 0 0
4 0 1 2 3
"""


def test_ascii_ply(tmp_path):
    (tmp_path / "a.ply").write_text(ASCII)
    mesh = read_mesh(tmp_path / "a.ply")
    np.testing.assert_allclose(mesh.vertices, POINTS)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.colours[0].tolist() == [1, 0, 0]


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_ply(tmp_path, order):
    mark = "<" if order == "little" else ">"
    head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex 4\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    body = POINTS.astype(mark + "f4").tobytes() + struct.pack(mark + "B4i", 4, 0, 1, 2, 3)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    mesh = read_mesh(tmp_path / "a.ply")
    np.testing.assert_allclose(mesh.vertices, POINTS)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def glb(**changed) -> bytes:
    index = np.array([0, 1, 2, 0, 2, 3], np.uint16)
    data = POINTS.tobytes() + index.tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"translation": [0, 0, 5], "scale": [2, 2, 2], "children": [1]}, {"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [{"byteLength": len(data)}],
    } | changed
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def test_glb_where_its_nodes_put_it(tmp_path):
    (tmp_path / "a.glb").write_bytes(glb())
    mesh = read_mesh(tmp_path / "a.glb")
    np.testing.assert_allclose(mesh.vertices, POINTS * 2 + [0, 0, 5])
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.ply", b"nothing", "not a PLY file"),
        ("a.ply", ASCII.replace("4 0 1 2 3", "4 0 1 2 9").encode(), "beyond the 4 there are"),
        ("a.ply", ASCII.replace("1 1 0 255", "1 x 0 255").encode(), "damaged PLY"),
        ("a.ply", ASCII.replace("4 0 1 2 3\n", "").encode(), "damaged PLY"),
        ("a.ply", ASCII.replace("ascii", "binary_pdp_endian").encode(), "damaged PLY"),
        ("a.glb", b"glTFxxxx", "is cut off"),
        ("a.glb", glb(extensionsRequired=["EXT_unknown"]), "EXT_unknown"),
        ("a.glb", glb(nodes=[{"children": [1]}, {"children": [0]}]), "its own ancestor|two parents"),
        ("a.glb", glb(meshes=[{"primitives": [{"attributes": {"POSITION": 7}}]}]), "there is no accessors.7."),
        ("a.obj", b"v 0 0 0\nv 1 0 0\n", "has no faces"),
        ("a.stl", b"", "not an STL file, or cut off"),
        ("a.xyz", b"", "is read from .obj, .ply, .stl"),
    ],
)
def test_faults(tmp_path, name, content, told):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=told):
        read_mesh(tmp_path / name)


def test_a_picture_needs_texture_places(tmp_path):
    (tmp_path / "a.ply").write_text(ASCII)
    with pytest.raises(InputError, match="no texture places"):
        read_mesh(tmp_path / "a.ply", tmp_path / "a.png")


def test_obj_with_a_picture_is_split_at_its_seams(tmp_path):
    Image.fromarray(np.full((4, 4, 3), 90, np.uint8)).save(tmp_path / "skin.png")
    (tmp_path / "head.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
    text = "mtllib head.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.5\n"
    (tmp_path / "head.obj").write_text(text + "f 1/1 2/2 3/3\nf 1/4 3/3 4/-1\n")
    mesh = read_mesh(tmp_path / "head.obj")
    assert mesh.texture is not None
    assert mesh.texture.shape == (4, 4, 3)
    assert mesh.triangles.tolist() == [[0, 1, 2], [4, 2, 3]]
    np.testing.assert_allclose(mesh.vertices[4], mesh.vertices[0])
    np.testing.assert_allclose(mesh.uv, [[0, 1], [1, 1], [1, 0], [0.5, 0.5], [0.5, 0.5]])


def test_binary_ply_of_triangles_at_once(tmp_path):
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
    body = POINTS.tobytes() + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 0, 2, 3)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    assert read_mesh(tmp_path / "a.ply").triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_stl_binary_and_ascii(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    rows = np.zeros(2, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = corners.reshape(2, 3, 3)
    (tmp_path / "a.stl").write_bytes(b" " * 80 + (2).to_bytes(4, "little") + rows.tobytes())
    facets = ["facet outer loop " + " ".join("vertex {} {} {}".format(*c) for c in t) + " endloop endfacet"
              for t in corners.reshape(2, 3, 3)]  # fmt: skip
    (tmp_path / "b.stl").write_text("solid x " + " ".join(facets) + " endsolid x")
    for name in ("a.stl", "b.stl"):
        mesh = read_mesh(tmp_path / name)
        assert len(mesh.vertices) == 4
        np.testing.assert_allclose(mesh.vertices[mesh.triangles].reshape(-1, 3), corners)


@pytest.mark.parametrize("row", ["0 0 0", "1e300 {} 0", "{} 0 0"])
def test_points_without_a_surface_are_refused(row, tmp_path):
    (tmp_path / "a.obj").write_text("".join(f"v {row.format(i)}\n" for i in range(6)) + "f 1 2 3\nf 4 5 6\n")
    with pytest.raises(InputError, match="no surface"):
        read_mesh(tmp_path / "a.obj")


def test_usd_polygons_are_placed_and_cut_into_fans(tmp_path):
    (tmp_path / "a.usda").write_text(
        """#usda 1.0
def Xform "root" {
  double3 xformOp:translate = (0, 5, 0)
  uniform token[] xformOpOrder = ["xformOp:translate"]
  def Mesh "m" {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0)]
  }
}
"""
    )
    mesh = read_mesh(tmp_path / "a.usda")
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.vertices[2].tolist() == [1, 6, 0]

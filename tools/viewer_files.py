"""Write what the npm package `viewer/` shares with mien: the tables of names, and the golden files of its tests.

    python tools/viewer_files.py [FOLDER]

FOLDER is the package (`viewer/` beside this folder). Its files are committed; `tests/test_viewer_package.py` compares.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from tests.faces import tiny_animation, tiny_face

from mien.core.channels import ALL, HEAD, WEIGHTS
from mien.face.foreign.rig_names import Convention, conventions, name_tables, recognised
from mien.face.tree_config import parse_tree
from mien.face.tree_data import config_data, influence_data
from mien.formats.driven_glb import drive_glb
from mien.formats.gltf import write_glb
from mien.formats.gltf_buffer import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, GltfBuffer, pack_glb
from mien.formats.native import write_native
from mien.serve.live.frames import END, Frame, Greeting, encode_frame

FRAMES = 6


CONVENTIONS = ("ARKit", "Oculus visemes", "VRM and five vowels", "VRoid, VRM lids and MMD")
"""What of mien's tables of names the player carries; it takes others from a `mien face inspect`."""
SPELT = (
    "jaw_open",
    "blendShape1.jawOpen",
    "browDown_L",
    "Left_eyeBlink",
    "mouthRollLower_R",
    "viseme_aa",
    "viseme_PP",
    "viseme_O",
    "A",
    "I",
    "U",
    "Fcl_MTH_O",
    "nonsense",
    "constructor",
    "MOUTHSMILELEFT",
    "nostrilDilator_L",
    "あ",
    "い",
)


def tables() -> str:
    """The source of ``viewer/src/tables.ts``."""
    names = name_tables()

    def table(content: object) -> str:
        return json.dumps(content, indent=1, ensure_ascii=False)

    known = [
        {
            "title": one.title,
            "kind": _kind(one),
            "needs": one.needs,
            "targets": {k: m.recipe for k, m in one.targets.items()},
        }
        for title in CONVENTIONS
        for one in conventions()
        if one.title == title
    ]
    constants = {
        "WEIGHTS: readonly string[]": WEIGHTS,
        "HEAD: readonly string[]": HEAD,
        "CONVENTIONS: readonly Convention[]": known,
        "NODES: Readonly<Record<string, readonly string[]>>": names["nodes"],
        "EYE_DEGREES: Readonly<Record<string, number>>": {way.lower(): value for way, value in names["eyes"].items()},
    }
    first = (
        "// Written by tools/viewer_files.py from mien.core.channels and src/mien/assets/rigs. Do not edit.\n"
        + CONVENTION
    )
    return first + "".join(f"export const {name} = {table(value)};\n" for name, value in constants.items())


CONVENTION = """export interface Convention {
  title: string; kind: string; needs: number; targets: Readonly<Record<string, Readonly<Record<string, number>>>>;
}
"""


def _kind(convention: Convention) -> str:
    return next(match.kind for match in convention.targets.values() if match.kind != "spare")


def spelt() -> dict[str, object]:
    """What mien itself makes of names, each seen among enough of its kind."""
    found = recognised(SPELT)
    told = {
        name: match and match.convention in CONVENTIONS and match.recipe
        for name, match in zip(SPELT, found, strict=True)
    }
    return {name: recipe or {} for name, recipe in told.items()}


def foreign_glb(path: Path) -> None:
    """A triangle with targets spelt in another way, under a head bone that stands askew."""
    buffer = GltfBuffer()
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    names = ["blendShape1.jaw_open", "browDown_L", "unknown"]
    position = buffer.add(corners, ARRAY_BUFFER, bounds=True)
    index = buffer.add(np.array([0, 1, 2], np.uint16), ELEMENT_ARRAY_BUFFER)
    moved = [{"POSITION": buffer.add(corners * 0.1 * (n + 1), ARRAY_BUFFER, bounds=True)} for n in range(3)]
    half = float(np.sqrt(0.5))
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "hips", "children": [1], "rotation": [half, 0.0, 0.0, half]},
            {"name": "mixamorig:Head", "children": [2], "rotation": [0.0, 0.0, half, half]},
            {"name": "face", "mesh": 0},
        ],
        "meshes": [
            {
                "primitives": [{"attributes": {"POSITION": position}, "indices": index, "targets": moved}],
                "extras": {"targetNames": names},
            }
        ],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    path.write_bytes(pack_glb(document, buffer.data))


def write(folder: Path) -> None:
    """Write all of it under the package's folder."""
    (folder / "src" / "tables.ts").write_text(tables(), "utf-8")
    golden = folder / "test" / "golden"
    golden.mkdir(parents=True, exist_ok=True)
    animation = tiny_animation(FRAMES)
    write_native(animation, golden / "line.json")
    write_glb(animation, tiny_face(), golden / "line.glb")
    foreign_glb(golden / "foreign.glb")
    drive_glb(animation.channels, golden / "foreign.glb", golden / "driven.glb")
    greeting = Greeting(tuple(ALL), animation.rate.fps, {"text": animation.utterance.text, "seconds": 0.24})
    times = animation.rate.times(FRAMES)
    rows = animation.channels.values
    frames = [Frame(number, float(times[number]), rows[number]) for number in (0, 1, 2, 4, 5)]  # one was passed over
    (golden / "greeting.txt").write_text(greeting.encode(), "utf-8")
    (golden / "end.txt").write_text(END, "utf-8")
    (golden / "frames.bin").write_bytes(b"".join(encode_frame(frame) for frame in frames))
    (golden / "names.json").write_text(json.dumps(spelt(), ensure_ascii=False, indent=1) + "\n", "utf-8")
    (golden / "values.json").write_text(json.dumps({"channels": ALL, "values": rows.tolist()}) + "\n", "utf-8")


TREE = """mien-tree 1
parameter head
  rotation axis 0 1 0.2 pivot 0 -90 -40
  all 1
parameter jaw
  rotation axis 1 0 0 pivot 0 -20 -60
  parent head
  group skeletal
  sphere 0 -70 0 radius 20 soft 40
parameter trunk
  fixed
  group skeletal
  side 0 -1 0 of 0 -80 0 soft 20
parameter smile
  translation 3 4 -1
  parent jaw
  sphere 25 -64 16 radius 6 soft 18 weight 0.8
parameter brow
  translation 0 5 0
  weights skin 0:0.5 3-5:1
"""


def write_tree(folder: Path) -> None:
    """Write ``golden/tree.json`` for the studio's page: a small tree, and what `ParameterTree.deform` makes of it."""
    points = np.random.default_rng(5).uniform((-60, -110, -60), (60, 40, 40), (24, 3)).astype(np.float32)
    rest = {"skin": points[:16], "teeth": points[16:]}
    config = parse_tree(TREE)
    tree = config.on(rest)
    names = [parameter.name for parameter in tree.parameters]
    cases = []
    for values in (
        {},
        {"head": 20.0},
        {"jaw": -12.0, "smile": 1.0},
        {"head": 15.0, "jaw": 8.0, "smile": 0.7, "brow": -1.2},
    ):
        row = [values.get(name, 0.0) for name in names]
        posed = {part: tree.deform(part, vertices, row).tolist() for part, vertices in rest.items()}
        cases.append({"values": values, "vertices": posed})
    content = {"config": config_data(config), "influences": influence_data(tree), "cases": cases}
    folder.mkdir(parents=True, exist_ok=True)
    content["rest"] = {part: vertices.tolist() for part, vertices in rest.items()}
    (folder / "tree.json").write_text(json.dumps(content) + "\n", "utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent.parent / "viewer")
    write_tree(Path(__file__).parent.parent / "studio" / "test" / "golden")

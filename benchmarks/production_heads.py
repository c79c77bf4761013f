"""How near `mien face fit`, without a landmark, comes to the shapes that artists gave the same heads.

::

    MIEN_DATA=... python benchmarks/production_heads.py [openfacefx-0.24.0-py3-none-any.whl] [--files PATH ...]

writes ``docs/tables/production_heads.md`` and ``docs/pictures/production_heads.jpg``. The first head is ICT-FaceKit's
(MIT, in the shared data), the second the head of three.js' facecap example, which lies in that wheel: a second artist's
answer, and what two artists agree on. ``--files`` are further real files (heads of any format, avatars, photographs of
faces): what mien says of each goes into the table.
"""

from __future__ import annotations

import argparse
import gzip
import os
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from PIL import Image

from mien.core.channels import ARKIT
from mien.core.errors import InputError
from mien.core.files import replace_when_complete
from mien.face.foreign.drawn import drawn_face
from mien.face.foreign.foreign_report import inspect_face
from mien.face.foreign.known_face import known_face
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.renderer import Renderer
from mien.face.surface import Surface
from mien.fit.fit_head import FittedHead, GivenMesh, fit_head
from mien.fit.from_photos import face_from_photos
from mien.fit.mesh_files import read_mesh, read_picture
from mien.fit.photo_marks import marks_from_tracker
from mien.fit.shape_transfer import carry_over, openings

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "production_heads.md"
PICTURE = TABLE.parent.parent / "pictures" / "production_heads.jpg"
MOVING_MM = 0.5
POSES: tuple[dict[str, float], ...] = (
    {},
    {"jawOpen": 1.0},
    {"jawOpen": 1.0, "mouthClose": 1.0},
    {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
    {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0},
    {"mouthPucker": 1.0},
    {"jawOpen": 0.7, "tongueOut": 1.0},
)
ABOUT = """
Written by `python benchmarks/production_heads.py WHEEL`. Both heads have shapes of their artists; `mien face fit`
gets the mesh alone, at rest, and no landmarks. Over the skin's vertices that the artist's shape moves by more than
{moving} mm, **error** is the mean distance of our offsets from the artist's as a share of the mean movement (no shape
at all: 100 %), **cosine** that of all offsets together. **Artists**: the second head's shapes carried to the first one
by the same two fits, against the first artist's: how far two artists agree (one pair, and the fits' own error
is in it). Our shapes go part of the way to ict-head's (`tools/bake_face/second_artist.py`): its column says how well
shapes are carried. Of facecap nothing is in them but that shares and sizes were chosen by it: its column says how near
they are to another artist's.
"""


def ict_head() -> tuple[GivenMesh, dict[str, np.ndarray]]:
    """Mesh in centimetres and true offsets in mm."""
    folder = Path(os.environ["MIEN_DATA"]) / "ict-head"
    with tempfile.TemporaryDirectory() as there:
        plain = Path(there) / "neutral.obj"
        plain.write_bytes(gzip.decompress((folder / "neutral.obj.gz").read_bytes()))
        mesh = read_mesh(plain)
    stored, truth = np.load(folder / "shapes.npz"), {}
    for name in ARKIT:
        short = name.removesuffix("Left") + "_L" if name.endswith("Left") else name.removesuffix("Right") + "_R"
        parts = [key for key in (name, short, name + "_L", name + "_R") if key + ".vertices" in stored.files]
        if parts:
            truth[name] = np.zeros((len(mesh.vertices), 3))
            for key in parts:
                truth[name][stored[key + ".vertices"]] += 10.0 * stored[key + ".offsets"].astype(float)
    return mesh, truth


def facecap_head(wheel: Path) -> tuple[GivenMesh, dict[str, np.ndarray]]:
    """Mesh and true offsets, both in mm."""
    with tempfile.TemporaryDirectory() as there, zipfile.ZipFile(wheel) as archive:
        path = archive.extract("openfacefx/studio_web/assets/facecap.glb", there)
        face = drawn_face(known_face(path), pictures=False).by_channels()
    starts = np.cumsum([0, *(len(part.vertices) for part in face.parts)])
    vertices = np.concatenate([part.vertices for part in face.parts]).astype(float)
    triangles = np.concatenate([part.triangles + start for part, start in zip(face.parts, starts, strict=False)])
    truth = {name: np.zeros_like(vertices) for name in ARKIT if any(name in part.targets for part in face.parts)}
    for part, start in zip(face.parts, starts, strict=False):
        for name in truth:
            if name in part.targets:
                truth[name][part.targets[name].vertices + start] = part.targets[name].offsets
    bare = GivenMesh(vertices, triangles, np.zeros((len(vertices), 2)), np.ones((len(vertices), 3)))
    return bare, truth


def on_skin(done: FittedHead, truth: dict[str, np.ndarray], unit: float) -> dict[str, np.ndarray]:
    """True offsets on the vertices of the fitted skin's part, in its axes, mm."""
    turn = done.alignment.to_face.turn
    return {name: unit * offsets[done.kept] @ turn.T for name, offsets in truth.items()}


def compared(mine: dict[str, np.ndarray], truth: dict[str, np.ndarray]) -> dict[str, tuple[float, float]]:
    found = {}
    for name, wanted in truth.items():
        size = np.linalg.norm(wanted, axis=1)
        moving = size > MOVING_MM
        if moving.sum() >= 5:
            got, wanted = mine.get(name, np.zeros_like(wanted))[moving], wanted[moving]
            error = np.linalg.norm(got - wanted, axis=1).mean() / size[moving].mean()
            length = np.sqrt((got**2).sum() * (wanted**2).sum())
            found[name] = (float(error), float((got * wanted).sum() / max(length, 1e-9)))
    return found


def ours(done: FittedHead) -> dict[str, np.ndarray]:
    skin = done.face.part("skin")
    found = {}
    for name, target in skin.targets.items():
        found[name] = np.zeros((len(skin.vertices), 3))
        found[name][target.vertices] = target.offsets
    return found


def carried(source: FittedHead, shapes: dict[str, np.ndarray], goal: FittedHead) -> dict[str, np.ndarray]:
    """One head's shapes on another, by way of the default skin that lies on both."""
    space = head_space()
    bent = Surface(goal.fit.vertices, space.triangles)
    skin = goal.face.part("skin")
    points = skin.vertices.astype(float)
    away = Surface(points, skin.triangles)
    found = bent.closest(points, away.normals)
    at_source = Surface(source.fit.vertices, space.triangles)
    places = np.einsum("qk,qkd->qd", found.weights, at_source.vertices[space.triangles[found.triangle]])
    facing = np.einsum("qk,qkd->qd", found.weights, at_source.normals[space.triangles[found.triangle]])
    own = source.face.part("skin")
    there = Surface(own.vertices.astype(float), own.triangles).closest(places, facing)
    matrix = there.matrix(own.triangles, len(own.vertices))
    return {name: matrix @ offsets for name, offsets in shapes.items()}


def on_default(done: FittedHead, shapes: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """A head's shapes carried back to the default skin, mm, and how far the head is from each of its vertices, mm."""
    space, bent, skin = head_space(), done.fit.vertices, done.face.part("skin")
    head = Surface(skin.vertices.astype(float), skin.triangles)
    upper = carry_over(space, bent, head).upper
    normals = Surface(bent, space.triangles).normals
    found = head.closest(bent, normals)
    matrix, away = found.matrix(skin.triangles, len(skin.vertices)).tolil(), found.distance.copy()
    for key, (to_upper, to_lower) in openings(space).items():  # lips and lids take from their own side
        near = np.minimum(to_upper, to_lower) < (14.0 if key == "mouth" else 7.0)
        for sign, mine in ((1, to_upper < to_lower), (-1, to_lower <= to_upper)):
            chosen = np.flatnonzero(near & mine)
            among = np.asarray((upper[key][skin.triangles] * sign >= 0).all(axis=1))
            found = Surface(head.vertices, skin.triangles, among).closest(bent[chosen], normals[chosen])
            matrix[chosen], away[chosen] = found.matrix(skin.triangles, len(skin.vertices)), found.distance
    back = np.linalg.inv(reshaped_face(space, bent, "").jacobians)
    matrix = matrix.tocsr()
    return {name: np.einsum("nij,nj->ni", back, matrix @ offsets) for name, offsets in shapes.items()}, away


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, nargs="?", help="the openfacefx 0.24.0 wheel")
    parser.add_argument("--files", type=Path, nargs="*", default=[], help="further real files")
    given = parser.parse_args()
    wheel = given.wheel
    mesh, truth = ict_head()
    first = fit_head(mesh)
    first_truth = on_skin(first, truth, first.alignment.to_face.scale / 10)
    columns = {"ict-head": (first, compared(ours(first), first_truth))}
    agreed = {}
    if wheel is not None:
        bare, other = facecap_head(wheel)
        second = fit_head(bare)
        second_truth = on_skin(second, other, second.alignment.to_face.scale)
        columns["facecap"] = (second, compared(ours(second), second_truth))
        agreed = compared(carried(second, second_truth, first), first_truth)
    text = written(columns, agreed) + real_files(given.files)
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    sheet([done.face for done, _ in columns.values()]).save(PICTURE, quality=88)
    print(TABLE, PICTURE)


def sheet(faces: list[Face]) -> Image.Image:
    """Each face at rest and in some shapes, a row a face."""
    names = sorted({name for pose in POSES for name in pose})
    rows = []
    for face in faces:
        poser, renderer = Poser(face, names), Renderer(face, 300, 300, camera=Camera.head_shot(face, 1.0))
        poses = [np.array([pose.get(name, 0.0) for name in names]) for pose in POSES]
        rows.append(np.hstack([renderer.render(poser.pose(pose))[:, :, :3] for pose in poses]))
    return Image.fromarray(np.vstack(rows))


def real_files(paths: list[Path]) -> str:
    """What mien says of further files, as a section of the table."""
    if not paths:
        return ""
    lines = [
        "",
        "## Other files",
        "",
        "What mien itself says of them (`face inspect`, `face fit`, `from-photos`).",
        "",
    ]
    lines += ["| file | what is said |", "| --- | --- |"]
    for path in paths:
        try:
            told = said_of(path)
        except InputError as problem:
            told = f"refused: {problem}".replace(str(path), path.name)
        lines.append(f"| {path.name} | {told.replace('|', '/')} |")
        print(lines[-1], flush=True)
    return "\n".join(lines) + "\n"


def said_of(path: Path) -> str:
    if path.suffix.lower() in (".png", ".jpg", ".jpeg"):
        photo = marks_from_tracker(path.name, read_picture(path))
        return "; ".join(note.message for note in face_from_photos([photo]).notes)
    if path.suffix.lower() in (".glb", ".gltf", ".vrm"):
        report = inspect_face(path)
        if report.moves:
            driven = sum(len(mesh.driven) for mesh in report.meshes)
            count = sum(len(mesh.targets) for mesh in report.meshes)
            return f"{report.kind}, {driven} of {count} targets are driven; {report.verdict()}"
    done = fit_head(read_mesh(path), where=str(path))
    return "fitted: " + "; ".join(finding.words for finding in done.findings)


def written(columns: dict[str, tuple[FittedHead, dict[str, tuple[float, float]]]], agreed) -> str:  # type: ignore[no-untyped-def]
    results = {name: rows for name, (_, rows) in columns.items()} | ({"artists": agreed} if agreed else {})
    lines = ["# Heads of other makers against their artists' shapes", "", ABOUT.format(moving=MOVING_MM).strip(), ""]
    lines += ["| | " + " | ".join(results) + " |", "| --- |" + " --- |" * len(results)]
    for label, pick in (
        ("error, median of the shapes", lambda v: f"{100 * np.median(v[:, 0]):.0f} %"),
        ("cosine, median", lambda v: f"{np.median(v[:, 1]):.2f}"),
        ("error, worst shape", lambda v: f"{100 * v[:, 0].max():.0f} %"),
    ):
        cells = [pick(np.array(list(rows.values()))) for rows in results.values()]
        lines.append(f"| {label} | " + " | ".join(cells) + " |")
    lines += ["", "What is seen of the fitted heads:", ""]
    for name, (done, _) in columns.items():
        lines.append(f"* {name}: " + "; ".join(finding.words for finding in done.findings))
    lines += ["", "![fitted heads](../pictures/production_heads.jpg)", ""]
    lines.append("(Rest, jaw open, lips shut over an open jaw, blink, smile, pucker, tongue out.)")
    lines += ["", "| shape | " + " | ".join(f"{name}: error, cosine" for name in results) + " |"]
    lines.append("| --- |" + " --- |" * len(results))
    for name in ARKIT:
        cells = [f"{100 * r[name][0]:.0f} %, {r[name][1]:.2f}" if name in r else "" for r in results.values()]
        if any(cells):
            lines.append(f"| `{name}` | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()

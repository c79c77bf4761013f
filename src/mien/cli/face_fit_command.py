"""``mien face fit``: a bare head mesh becomes a face that mien can move."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.face.model import Face
    from mien.fit.fit_head import FittedHead
    from mien.fit.head_parts import GivenMesh

__all__ = ["add_command"]


def add_command(kinds: Any) -> None:
    """Add ``mien face fit`` to the face commands."""
    parser = kinds.add_parser("fit", help="give a bare head mesh the 52 ARKit shapes")
    parser.add_argument(
        "mesh", metavar="HEAD.obj", nargs="?", help="the head: .obj, .ply, .stl, .glb, .gltf or .vrm, any unit and axes"
    )
    parser.add_argument(
        "--landmarks",
        metavar="POINTS",
        help=".csv, .json or .toml: names with places or vertices, or iBUG's 68 points (.pts); as hints "
        "(default: found automatically)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FACE",
        help="FACE.npz, for --face FACE.npz; or .glb: for a .glb, .gltf or .vrm this is the same file with the "
        "shapes added to its meshes",
    )
    parser.add_argument("--also", metavar="OUT.glb", help="the face as a GLB with its morph targets, at rest")
    parser.add_argument("--texture", metavar="PICTURE", help="the texture picture of the mesh")
    parser.add_argument(
        "--unwrap",
        metavar="LAYOUT.png",
        help="give a head without texture coordinates some (cut open at the back, laid flat) and draw their layout, to "
        "paint over and give as --texture; for a FACE.npz",
    )
    parser.add_argument("--unit", help="of the mesh: mm, cm, dm, m or inch (default: found from the head's size)")
    parser.add_argument(
        "--add",
        metavar="PARTS",
        default="eyes,teeth,tongue,mouth",
        help="what the default face adds if the head has none: eyes teeth tongue mouth lashes brows hair shirt, "
        "separated by commas, or 'none' (default: eyes,teeth,tongue,mouth)",
    )
    parser.add_argument("--list-landmarks", action="store_true", help="print the names of all landmarks")
    parser.set_defaults(run=_fit)


def _fit(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.core.files import check_writable

    if options.list_landmarks:
        return _list_landmarks()
    missing = [name for name, value in (("HEAD.obj", options.mesh), ("-o", options.output)) if value is None]
    if missing:
        raise InputError(f"mien face fit needs HEAD.obj and -o; missing: {', '.join(missing)}")
    path = check_writable(options.output)
    if path.suffix.lower() not in (".npz", ".glb", ".vrm"):
        raise InputError(f"-o {path}: a face file ends in .npz, or in .glb or .vrm")
    also = None
    if options.also is not None:
        also = check_writable(options.also)
        if also.suffix.lower() != ".glb":
            raise InputError(f"--also {also}: expected a name that ends in .glb")
    layout = None
    if options.unwrap is not None:
        layout = check_writable(options.unwrap)
        if layout.suffix.lower() != ".png" or path.suffix.lower() != ".npz":
            raise InputError(f"--unwrap {layout} -o {path}: expected a LAYOUT.png, and a FACE.npz as the output")
    read = [type(path)(name).resolve() for name in (options.mesh, options.landmarks, options.texture) if name]
    if path.resolve() in read or (also is not None and also.resolve() in read):
        raise InputError(f"{path if path.resolve() in read else also} is both read and written: give it another name")
    _check_unit(options.unit)
    return _fitted(options, _parts(options.add), path, also, layout)


def _check_unit(unit: str | None) -> None:
    from mien.core.errors import unknown_name
    from mien.fit.alignment import UNITS

    if unit is not None and unit not in UNITS:
        raise unknown_name("unit", unit, UNITS)


def _parts(text: str) -> tuple[str, ...]:
    from mien.core.errors import unknown_name
    from mien.fit.head_parts import ADDED

    names = tuple(name.strip() for name in text.split(",") if name.strip() and name.strip() != "none")
    for name in names:
        if name not in ADDED:
            raise unknown_name("part", name, ADDED)
    return names


def _fitted(options: argparse.Namespace, added: tuple[str, ...], path: Any, also: Any, layout: Any) -> int:
    from math import isnan
    from pathlib import Path

    from mien.core.errors import InputError
    from mien.face.storage import write_face
    from mien.fit.fit_head import fit_head
    from mien.fit.landmarks import read_landmarks
    from mien.fit.mesh_files import read_mesh

    landmarks = read_landmarks(options.landmarks) if options.landmarks else {}
    mesh = read_mesh(options.mesh, None if layout else options.texture)
    if layout and mesh.uv.any():
        raise InputError(f"{options.mesh} has texture coordinates already: leave --unwrap out")
    own_file = path.suffix.lower() != ".npz" and bool(mesh.origins)
    lent = () if own_file else added
    done = fit_head(mesh, landmarks, Path(options.mesh).stem, options.unit, lent, options.mesh)
    refused = [finding.words for finding in done.findings if finding.kind == "refusal"]
    if isnan(done.lip_gap) and isnan(done.lid_gap):
        refused.append(f"neither lips nor lids that part were found on its {len(done.kept)} vertices")
    if refused:
        raise InputError(f"{options.mesh}: the fit is not kept: {'; '.join(refused)}; give --landmarks by hand")
    print(_report(done, len(landmarks)))
    if layout:
        done = _unwrapped(done, options, layout)
    if own_file:
        _write_own_file(done, mesh, options.mesh, path)
    elif path.suffix.lower() == ".npz":
        write_face(done.face, path)
        names = ", ".join(p.name for p in done.face.parts)
        print(f"{path}: targets: {len(done.face.part('skin').targets)}, parts: {names}")
    else:
        write_rest(done.face, path)
        print(f"{path}: the face at rest, with its morph targets")
    if also is not None:
        write_rest(done.face, also)
        print(f"{also}: the face at rest, with its morph targets")
    return 0


def _unwrapped(done: FittedHead, options: argparse.Namespace, layout: Any) -> FittedHead:
    """The face with texture coordinates on its skin, their layout drawn, and painted if there is a picture."""
    from dataclasses import replace

    from PIL import Image

    from mien.core.files import replace_when_complete
    from mien.fit.mesh_files import read_picture
    from mien.fit.unwrap import layout_picture, unwrapped

    skin = done.face.part("skin")
    found = unwrapped(skin, options.mesh)
    with replace_when_complete(layout) as unfinished:
        Image.fromarray(layout_picture(found.part)).save(unfinished, "PNG")
    told = (
        f"triangles turned over: {found.turned}, 90 % of the skin has 1/{found.spread:.1f} to {found.spread:.1f} times"
    )
    print(f"{layout}: layout of the texture coordinates; {told} its share of the picture")
    part = found.part
    if options.texture:
        part = replace(part, material=replace(part.material, texture=read_picture(options.texture), colour=(1, 1, 1)))
    parts = tuple(part if each is skin else each for each in done.face.parts)
    return replace(done, face=replace(done.face, parts=parts))


def _write_own_file(done: FittedHead, mesh: GivenMesh, source: str, path: Any) -> None:
    from mien.face.foreign.gltf_document import read_gltf
    from mien.fit.in_own_file import shapes_of_file
    from mien.formats.shaped_glb import write_shapes

    shapes = shapes_of_file(done, mesh)
    for note in write_shapes(read_gltf(source), shapes, path):
        print(f"{note.kind}: {note.message}")
    count = len({name for each in shapes for name in each.targets})
    print(f"{path}: {source} with {count} targets on {len(shapes)} of its meshes' primitives, all else kept")


def write_rest(face: Face, path: Any) -> None:
    """A face at rest as a GLB: one frame of silence."""
    import numpy as np

    from mien.animation.animation import imported
    from mien.core.channels import ARKIT
    from mien.core.timeline import FrameRate
    from mien.core.tracks import ChannelTrack
    from mien.formats.gltf import write_glb

    rest = ChannelTrack(ARKIT, np.zeros((1, len(ARKIT)), np.float32), FrameRate.of(30))
    write_glb(imported(rest, "nothing: the face at rest"), face, path)


def _report(done: FittedHead, landmarks: int) -> str:
    import numpy as np

    from mien.fit.head_regions import region_distances

    unit = f"in {done.alignment.unit}" if done.alignment.unit else "of no human size, scaled"
    lines = [f"landmarks: {landmarks or 'found'}; the mesh is {unit}; vertices: {len(done.kept)}"]
    lines.append("default skin on the head, mean / 95 % distance in mm, and share of the region that was matched:")
    for region, (mean, high, share) in region_distances(done.fit).items():
        told = "no match" if np.isnan(mean) else f"{mean:.2f} / {high:.2f}"
        lines.append(f"  {region}: {told}, {100 * share:.0f} %")
    lines += [f"{finding.note.kind}: {finding.words}" for finding in done.findings]
    lines += [f"{note.kind}: {note.message}" for note in done.notes]
    return "\n".join(lines)


def _list_landmarks() -> int:
    from mien.fit.landmarks import known_landmarks

    for name, landmark in known_landmarks().items():
        print(f"{name}{' (needed)' if landmark.needed else ''}: {landmark.words}")
    return 0

"""``mien face check | tree | parameters | articulation``: parameter trees and where they come from."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.face.model import Face

__all__ = ["add_commands"]


def add_commands(kinds: Any) -> None:
    """Add the commands about parameter trees."""
    check = kinds.add_parser(
        "check", help="check whether a parameter tree fits a mesh; errors are printed with their lines"
    )
    check.add_argument("config", metavar="X.tree", help="the configuration")
    check.add_argument("--mesh", metavar="X.obj", help="the OBJ file it is for")
    check.add_argument("--face", metavar="NAME", help="the face it is for")
    check.set_defaults(run=_check)

    tree = kinds.add_parser("tree", help="write the parameter tree that corresponds to a face's morph targets")
    tree.add_argument("face", metavar="NAME", help="the face, such as default")
    tree.add_argument("-o", "--output", metavar="X.tree", required=True, help="the file to write")
    tree.set_defaults(run=_tree)

    parameters = kinds.add_parser("parameters", help="derive parameters by principal components from example poses")
    parameters.add_argument(
        "poses", metavar="POSE.obj", nargs="+", help="meshes with the same vertices in different poses"
    )
    parameters.add_argument("-o", "--output", metavar="X.tree", required=True, help="the file to write")
    parameters.add_argument("--rest", metavar="REST.obj", help="the mesh at rest (default: the first pose)")
    parameters.add_argument("--count", type=int, metavar="N", help="how many parameters (default: see --variance)")
    parameters.add_argument(
        "--variance", type=float, default=0.95, metavar="0..1", help="share of the variance to keep (default 0.95)"
    )
    parameters.add_argument(
        "--directions",
        type=int,
        default=3,
        choices=(1, 2, 3),
        help="translations per parameter: 3 shows a component exactly, 1 is the paper's (default 3)",
    )
    parameters.set_defaults(run=_parameters)

    articulation = kinds.add_parser(
        "articulation", help="learn five articulatory parameters from a corpus and put them on a face"
    )
    articulation.add_argument("corpus", metavar="CORPUS", help="a corpus made by 'mien corpus import'")
    articulation.add_argument("-o", "--output", metavar="X.tree", required=True, help="the file to write")
    articulation.add_argument("--face", default="default", metavar="NAME", help="the face (default: default)")
    articulation.add_argument("--directions", type=int, default=3, choices=(1, 2, 3), help="as for 'parameters'")
    articulation.add_argument(
        "--parameters-only",
        action="store_true",
        help="let channels move only the five parameters, without leaves for what those cannot express, such as "
        "a smile",
    )
    articulation.add_argument("--pictures", metavar="X.png", help="draw each parameter at -2 and +2 into this file")
    articulation.set_defaults(run=_articulation)


def _articulation(options: argparse.Namespace) -> int:
    from mien.core.files import check_writable
    from mien.corpus.recordings import Corpus
    from mien.face.library import load_face
    from mien.face.marker_regions import sites_of_layout
    from mien.face.tree_config import write_tree
    from mien.motion.mouth.articulatory import (
        ArticulatoryModel,
        articulatory_tree,
        held_out_errors,
        speaking_frames,
        takes_apart,
    )

    path = check_writable(options.output)
    face = load_face(options.face)
    sites_of_layout(face)  # a face on which no markers can sit is refused before any work
    corpus = Corpus(options.corpus)
    kept, held = takes_apart(list(corpus))
    positions, markers, layout = speaking_frames(kept)
    model = ArticulatoryModel().fit(positions, markers, layout)
    told = [f"{len(kept)} takes, {len(positions)} frames of speech, {len(markers)} mouth markers ({layout})"]
    told += model.summary().splitlines()
    if held:
        apart = speaking_frames(held)[0]
        told.append(f"RMS distance on {len(held)} takes held out ({len(apart)} frames):")
        told += [f"  {name}: {e:.2f} mm" for name, e in held_out_errors(model, apart, positions, face).items()]
    tree = articulatory_tree(model, face, options.directions, remainders=not options.parameters_only)
    about = f"articulatory parameters of face {options.face!r} by 'mien face articulation'\n" + "\n".join(told)
    write_tree(tree, path, about)
    print("\n".join(told))
    if options.pictures:
        from mien.inspection.articulation_sheet import draw_articulation

        draw_articulation(tree, face, options.pictures)
    print(f"{options.output}: parameters: {len(tree)}")
    return 0


def _check(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.face.tree_config import check_tree, read_tree

    if options.mesh is not None and options.face is not None:
        raise InputError("give --mesh or --face, not both")
    config = read_tree(options.config)
    face = _face_for(options)
    vertices = None if face is None else {part.name: part.vertices for part in face.parts}
    faults = check_tree(config, vertices)
    for line, fault in faults:
        print(f"{options.config}:{line}: {fault}")
    if faults:
        print(f"{options.config}: faults: {len(faults)}")
        return 2
    where = "" if face is None else f" on {options.mesh or options.face}"
    print(f"{options.config}: parameters: {len(config.drafts)}, no faults{where}")
    if face is not None:
        from mien.face.mesh_check import mesh_notes
        from mien.face.tree_report import tree_report

        for note in mesh_notes(face):
            print(f"{options.mesh or options.face}: {note}")
        print(tree_report(config.on(vertices or {}), face))
    return 0


def _face_for(options: argparse.Namespace) -> Face | None:
    from mien.face.library import load_face

    return load_face(options.mesh or options.face) if options.mesh or options.face else None


def _tree(options: argparse.Namespace) -> int:
    from mien.core.files import check_writable
    from mien.face.library import load_face
    from mien.face.tree_config import write_tree
    from mien.face.tree_of_face import tree_of_face

    check_writable(options.output)
    tree = tree_of_face(load_face(options.face))
    write_tree(tree, options.output, f"derived by 'mien face tree' from the morph targets of face {options.face!r}")
    print(f"{options.output}: parameters: {len(tree)}")
    return 0


def _parameters(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.core.files import check_writable
    from mien.face.example_poses import parameters_of_poses, read_poses
    from mien.face.tree_config import write_tree

    path = check_writable(options.output)
    read = [*options.poses, *([options.rest] if options.rest else [])]
    if any(path.resolve() == type(path)(name).resolve() for name in read):
        raise InputError(f"{path} is both read and written: give the output another name")
    rest, poses = read_poses(options.poses, options.rest)
    found = parameters_of_poses(
        rest, poses, count=options.count, variance=options.variance, directions=options.directions
    )
    write_tree(found.tree, path, found.about)
    print(found.about)
    print(f"{options.output}: parameters: {len(found.shares)}, translations: {len(found.tree)}")
    return 0

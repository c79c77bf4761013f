"""``mien face inspect``: what of a GLB's morph targets mien can drive."""

from __future__ import annotations

import argparse
import json
from typing import Any

__all__ = ["add_command"]

# What a face cannot do without a channel; authored.
_COSTS = {
    "jawOpen": "the mouth cannot open",
    "mouthClose": "lips cannot meet over an open jaw",
    "mouthPucker": "no rounding for /u w/",
    "mouthFunnel": "no open rounding for /o/",
    "mouthRollLower": "lower lip cannot reach the teeth for /f v/",
    "eyeBlinkLeft": "the left eye cannot blink",
    "eyeBlinkRight": "the right eye cannot blink",
}


def add_command(kinds: Any) -> None:
    """Add ``mien face inspect`` to the face commands."""
    parser = kinds.add_parser("inspect", help="what of a GLB's morph targets can be driven, and what is missing")
    parser.add_argument("glb", metavar="MY.glb", help="the face")
    parser.add_argument("--json", action="store_true", help="write the answer as JSON")
    parser.set_defaults(run=_inspect)


def _inspect(options: argparse.Namespace) -> int:
    from mien.output.driven_glb import driven_meshes, read_chunks
    from mien.output.turning_nodes import turning_nodes

    document, _ = read_chunks(options.glb)
    meshes: list[dict[str, Any]] = []
    for mesh in driven_meshes(options.glb, document):
        pairs = list(zip(mesh.targets, mesh.recipes, strict=True))
        known = {name: dict(recipe) for name, recipe in pairs if recipe}
        meshes.append({"mesh": mesh.name, "driven": known, "unknown": [name for name, recipe in pairs if not recipe]})
    nodes = {part: document["nodes"][number]["name"] for part, number in turning_nodes(document).items()}
    direct = {
        next(iter(recipe)) for mesh in meshes for recipe in mesh["driven"].values() if list(recipe.values()) == [1.0]
    }
    missing = {channel: cost for channel, cost in _COSTS.items() if channel not in direct}
    if options.json:
        print(json.dumps({"meshes": meshes, "nodes": nodes, "missing": missing}, indent=2))
        return 0
    for told in meshes:
        print(f"{told['mesh']}: {len(told['driven'])} targets known, {len(told['unknown'])} not known")
        for name, recipe in told["driven"].items():
            print(f"  {name} <- " + " ".join(f"{weight:+g} {channel}" for channel, weight in recipe.items()))
    for part in ("head", "eyeLeft", "eyeRight"):
        print(f"{part}: node {nodes[part]!r}" if part in nodes else f"{part}: no node of such a name; it stays still")
    for channel, cost in missing.items():
        print(f"no {channel} of its own: {cost}, unless a viseme shape does it")
    return 0

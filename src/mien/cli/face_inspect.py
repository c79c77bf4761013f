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
    from mien.output.driven_glb import read_chunks, recipe_of_target, target_names

    document, _ = read_chunks(options.glb)
    meshes: list[dict[str, Any]] = []
    for number, mesh in enumerate(document.get("meshes", [])):
        names = target_names(mesh)
        known = {name: dict(recipe_of_target(name)) for name in names if recipe_of_target(name)}
        unknown = [name for name in names if name not in known]
        meshes.append({"mesh": mesh.get("name", f"mesh {number}"), "driven": known, "unknown": unknown})
    direct = {
        next(iter(recipe)) for mesh in meshes for recipe in mesh["driven"].values() if list(recipe.values()) == [1.0]
    }
    missing = {channel: cost for channel, cost in _COSTS.items() if channel not in direct}
    if options.json:
        print(json.dumps({"meshes": meshes, "missing": missing}, indent=2))
        return 0
    for mesh in meshes:
        print(f"{mesh['mesh']}: {len(mesh['driven'])} targets known, {len(mesh['unknown'])} not known")
        for name, recipe in mesh["driven"].items():
            print(f"  {name} <- " + " ".join(f"{weight:+g} {channel}" for channel, weight in recipe.items()))
    for channel, cost in missing.items():
        print(f"no {channel} of its own: {cost}, unless a viseme shape does it")
    return 0

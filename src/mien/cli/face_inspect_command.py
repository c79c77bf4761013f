"""``mien face inspect``: what mien makes of a face of another maker."""

from __future__ import annotations

import argparse
import json
from typing import Any

__all__ = ["add_command"]


def add_command(kinds: Any) -> None:
    """Add ``mien face inspect`` to the face commands."""
    parser = kinds.add_parser("inspect", help="show what can be driven in a GLB, VRM or glTF face, and what is missing")
    parser.add_argument("glb", metavar="MY.glb", help="the face: .glb, .vrm or .gltf")
    parser.add_argument("--names", metavar="X.toml", help="your own table of names (docs/faces.md)")
    parser.add_argument("--write-names", metavar="X.toml", help="write a table of names to correct, for --names")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=_inspect)


def _inspect(options: argparse.Namespace) -> int:
    from mien.core.files import check_writable, replace_when_complete
    from mien.face.foreign.foreign_report import face_report, names_table
    from mien.face.foreign.known_face import known_face

    table = check_writable(options.write_names) if options.write_names else None
    face = known_face(options.glb, options.names)
    report = face_report(face)
    if table is not None:
        with replace_when_complete(table) as unfinished:
            unfinished.write_text(names_table(face), encoding="utf-8")
    print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False) if options.json else "\n".join(report.lines()))
    face.require_motion()
    return 0

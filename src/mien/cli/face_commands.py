"""``mien face``: the commands about faces themselves."""

from __future__ import annotations

from typing import Any

from mien.cli import (
    face_fit_command as face_fit,
)
from mien.cli import (
    face_inspect_command as face_inspect,
)
from mien.cli import (
    face_make_command as face_make,
)
from mien.cli import (
    face_photos_command as face_photos,
)
from mien.cli import (
    face_retarget_command as face_retarget,
)
from mien.cli import (
    face_rig_commands as face_rig,
)

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien face`` with its own commands."""
    face = commands.add_parser("face", help="make, fit, inspect and retarget faces")
    kinds = face.add_subparsers(title="face commands", required=True, metavar="FACE_COMMAND")
    face_rig.add_commands(kinds)
    face_inspect.add_command(kinds)
    face_fit.add_command(kinds)
    face_make.add_command(kinds)
    face_photos.add_command(kinds)
    face_retarget.add_command(kinds)

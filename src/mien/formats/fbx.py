"""``.fbx``: the GLB of a performance turned into FBX by Blender, for tools that take nothing else."""

from __future__ import annotations

from pathlib import Path

from mien.core.files import replace_when_complete
from mien.core.timeline import FrameRate
from mien.face.foreign.blender_bridge import blender_command, converted

__all__ = ["check_fbx", "fbx_of"]


def check_fbx() -> None:
    """Say early whether FBX can be written.

    Raises
    ------
    MissingPartError
        If there is no Blender.
    """
    blender_command()


def fbx_of(glb: Path, path: Path, rate: FrameRate) -> None:
    """Write the FBX of a GLB file.

    Raises
    ------
    MissingPartError, InputError
        As `mien.face.foreign.blender_bridge.converted`.
    OutputError
        If the file cannot be written.
    """
    content = converted(glb.read_bytes(), ".glb", ".fbx", rate, path.name)
    with replace_when_complete(path) as unfinished:
        unfinished.write_bytes(content)

"""FBX through Blender, a program of its own: the extra ``fbx``, an installed Blender, or ``MIEN_BLENDER``."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from mien.core.errors import InputError, MissingPartError
from mien.core.temporary_folder import temporary_folder
from mien.core.timeline import FrameRate
from mien.face.foreign import blender_worker

__all__ = ["blender_command", "converted"]

_MOST_SECONDS = 600


def blender_command() -> list[str]:
    """What runs a script in Blender.

    ``MIEN_BLENDER`` names a Blender or a Python that has it as the module ``bpy``; else this Python, if it has; else
    ``blender`` on the ``PATH``.

    Raises
    ------
    MissingPartError
        If there is none.
    """
    given = os.environ.get("MIEN_BLENDER")
    if given and shutil.which(given) is None:
        raise MissingPartError(f"MIEN_BLENDER is {given}: no such program")
    program = given or (sys.executable if find_spec("bpy") is not None else shutil.which("blender"))
    if program is None:
        raise MissingPartError(
            "FBX needs Blender: install it (https://www.blender.org), or pip install 'mien[fbx]' (Python 3.11)"
        )
    if "python" in Path(program).name.lower():
        return [program, blender_worker.__file__, "--"]
    return [program, "--background", "--factory-startup", "--python", blender_worker.__file__, "--"]


def converted(content: bytes, suffix: str, wanted: str, rate: FrameRate | None = None, name: str = "the file") -> bytes:
    """A GLB as FBX, or an FBX as GLB.

    Parameters
    ----------
    content : bytes
    suffix, wanted : {".glb", ".fbx"}
        What it is, and what it shall be.
    rate : FrameRate, optional
        Of its motion.
    name : str
        For messages.

    Raises
    ------
    MissingPartError
        If there is no Blender.
    InputError
        If Blender cannot read it.
    """
    command = blender_command()
    whole = math.ceil((rate or FrameRate.of(30)).fraction)
    base = float(whole / (rate or FrameRate.of(30)).fraction)
    with temporary_folder() as folder:
        source, target = folder / f"in{suffix}", folder / f"out{wanted}"
        source.write_bytes(content)
        try:
            ran = subprocess.run(
                [*command, str(source), str(target), str(whole), repr(base)],
                stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=_MOST_SECONDS,
                check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired as problem:
            raise InputError(f"{name}: Blender did not end within {_MOST_SECONDS} s") from problem
        if ran.returncode or not target.is_file():
            last = (ran.stderr.strip() or ran.stdout.strip() or "it said nothing").splitlines()[-1]
            raise InputError(f"{name}: Blender cannot turn it into {wanted[1:].upper()}: {last}")
        return target.read_bytes()

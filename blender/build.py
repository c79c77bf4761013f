"""Builds the extension: ``python blender/build.py`` (or ``make blender``) writes ``dist/mien_blender-VERSION.zip``.

The zip holds the extension, mien's own wheel and the pinned versions of what it needs, so that the button in Blender
installs exactly this version. Install it in Blender by dragging the file onto the window.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
EXTENSION = ROOT / "blender" / "mien_blender"


def build(folder: Path = ROOT / "dist") -> Path:
    """Write the zip into a folder; gives its path."""
    version = tomllib.loads((EXTENSION / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"mien_blender-{version}.zip"
    with tempfile.TemporaryDirectory() as made, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as package:
        wheel = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", made, str(ROOT)]
        subprocess.run(wheel, check=True)
        files = [
            *EXTENSION.glob("*.py"),
            EXTENSION / "blender_manifest.toml",
            ROOT / "constraints.txt",
            ROOT / "LICENSE",
        ]
        for file in sorted(files) + list(Path(made).glob("*.whl")):
            package.write(file, file.name)
    return path


if __name__ == "__main__":
    print(build())

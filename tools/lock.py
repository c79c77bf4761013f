"""Write ``requirements/``: every package that mien needs, with the hashes of all its files: ``make lock``.

``core.txt`` is what ``pip install .`` brings, and what builds it; ``EXTRA.txt`` is what an extra adds to that. Versions
are those of ``constraints.txt``. ``pip install --require-hashes -r requirements/core.txt`` takes nothing else.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
_ENTRY = re.compile(r"^[A-Za-z0-9].*?(?=^[A-Za-z0-9]|\Z)", re.MULTILINE | re.DOTALL)
_HEAD = "# By 'make lock' from pyproject.toml and constraints.txt; not to be edited.\n"


def locked(build: Path, *more: str) -> dict[str, str]:
    """The entries of a lock file, by the requirement that each begins with."""
    command = [
        *(
            sys.executable,
            "-m",
            "uv",
            "pip",
            "compile",
            "pyproject.toml",
            str(build),
            "--constraint",
            "constraints.txt",
        ),
        *("--universal", "--python-version", "3.11", "--generate-hashes", "--no-header", "--no-annotate", "--quiet"),
        *more,
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stderr.strip())
    return {entry.split(" \\", 1)[0]: entry for entry in _ENTRY.findall(done.stdout)}


def main() -> None:
    """Write all of them."""
    about = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folder = ROOT / "requirements"
    folder.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        build = Path(scratch) / "build.in"
        build.write_text("\n".join(about["build-system"]["requires"]) + "\n", encoding="utf-8")
        core = locked(build)
        files = {"core": core}
        for extra in about["project"]["optional-dependencies"]:
            files[extra] = {k: v for k, v in locked(build, "--extra", extra).items() if k not in core}
    for name, entries in files.items():
        (folder / f"{name}.txt").write_text(_HEAD + "".join(entries.values()), encoding="utf-8")
        print(f"requirements/{name}.txt: {len(entries)} packages")


if __name__ == "__main__":
    main()

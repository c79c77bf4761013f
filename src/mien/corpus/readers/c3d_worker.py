"""Reads one C3D file in a process of its own: the library, in C++, ends its process on some damaged files.

    python c3d_worker.py FILE.c3d OUT.npz

writes ``points``, ``residuals``, ``analogs`` and the parameters that the reader asks for (as JSON). It imports nothing
of mien, so that it starts quickly.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import numpy as np

__all__ = ["PARAMETERS", "main"]

PARAMETERS = (
    *(("POINT", name) for name in ("LABELS", "UNITS", "RATE", "ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")),
    ("ANALOG", "LABELS"),
    ("ANALOG", "RATE"),
)
_MOST_NAMES = 255  # one parameter holds no more; the others are in LABELS2, LABELS3 ...
_SECONDS, _BYTES_PER_SECOND, _BYTES = 15, 10_000_000, 8 * 2**30


def main(source: str, out: str) -> int:
    """Read; what the library has to say of a bad file goes to standard error, exit code 2."""
    _limit(source)
    import ezc3d

    try:
        content: Any = ezc3d.c3d(source)
        parameters = content["parameters"]
        facts = {
            f"{group}:{name}": [
                item if isinstance(item, str) else float(item) for item in parameters[group][name]["value"]
            ]
            for group, name in PARAMETERS
            if group in parameters and name in parameters[group]
        }
        for group in ("POINT", "ANALOG"):
            for number in range(2, _MOST_NAMES):
                if f"LABELS{number}" not in parameters.get(group, {}):
                    break
                facts[f"{group}:LABELS"] += parameters[group][f"LABELS{number}"]["value"]
        np.savez(
            out,
            points=np.asarray(content["data"]["points"], dtype=np.float64),
            residuals=np.asarray(content["data"]["meta_points"]["residuals"], dtype=np.float64),
            analogs=np.asarray(content["data"]["analogs"], dtype=np.float64),
            facts=np.frombuffer(json.dumps(facts).encode(), np.uint8),
        )
    except Exception as problem:  # the library raises what it likes
        print(" ".join(str(problem).split(". If")[0].split()) or type(problem).__name__, file=sys.stderr)
        return 2
    return 0


def _limit(source: str) -> None:
    """A file that makes the library run or grow without end costs this process, not the machine."""
    try:
        import resource

        seconds = _SECONDS + os.path.getsize(source) // _BYTES_PER_SECOND  # noqa: PTH202 - nothing else of pathlib here
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_AS, (_BYTES, _BYTES))
    except (ImportError, ValueError, OSError):
        return


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

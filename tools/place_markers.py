"""Write ``src/mien/assets/markers/*.toml``: where the markers of each layout sit on the default face.

::

    python tools/place_markers.py DATA/grid-s1

The 218 landmarks come from the mean closed-mouth shape of the tracked recordings (GRID speaker 1, CC BY 4.0), made
symmetric. It is laid on the default face by a similarity transform and a thin-plate-like spline through the places that
both know (``[sites]`` in tools/markers/landmarks.toml), then every landmark goes to the nearest point of the skin.
Irises go to the front of the eyeballs. The other layouts take their places from the landmarks. Run it again whenever
the default face changes.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from mien.capture.cleaning.normalise import apply, best_similarity, least_squares
from mien.core.timeline import FrameRate
from mien.core.tracks import MarkerTrack
from mien.face.library import load_face
from mien.face.model import Face

HERE = Path(__file__).parent
ASSETS = HERE.parent / "src" / "mien" / "assets" / "markers"
TAKES = 120  # of the set, evenly spread: enough for a mean
CLOSED = 0.1  # share of frames with the smallest lip opening
ABOUT = "218 landmarks of MediaPipe's face mesh: face oval, lips, eyes, brows, irises, nose, cheeks"
Floats = NDArray[np.float64]
IRISES = {"left": (473, 474, 475, 476, 477), "right": (468, 469, 470, 471, 472)}


def main() -> None:
    """Place all layouts."""
    chart = tomllib.loads((HERE / "markers" / "landmarks.toml").read_text(encoding="utf-8"))
    face = load_face()
    shape = symmetric(mean_shape(Path(sys.argv[1]), chart), chart)
    places = placed(shape, face, chart)
    names = {number: name for name, number in chart["names"].items()}
    names = {number: names.get(number, f"mp_{number:03d}") for number in chart["order"]}
    ASSETS.mkdir(parents=True, exist_ok=True)
    write("mediapipe-218", ABOUT, chart["order"], chart["rigid"], names, places, chart)
    sets = tomllib.loads((HERE / "markers" / "sets.toml").read_text(encoding="utf-8"))
    for name, entry in sets.items():
        write(name, entry["about"], entry["landmarks"], entry["rigid"], names, places, chart)


def mean_shape(data: Path, chart: dict[str, list[int]]) -> Floats:
    """Mean of the frames with closed lips, (landmarks, 3), y up and z forward, in the scale of the first frame."""
    order = chart["order"]
    with np.load(data / "markers.npz") as takes:
        chosen = takes.files[:: max(1, len(takes.files) // TAKES)]
        raw = np.concatenate([takes[name] for name in chosen]).astype(np.float64)
    raw = raw[(raw != -32768).all(axis=(1, 2))] * [1, -1, -1]
    track = MarkerTrack([str(number) for number in order], raw, FrameRate.of(25))
    still = least_squares(track, [str(number) for number in chart["rigid"]], raw[0], scale=True).track.positions
    upper, lower = order.index(13), order.index(14)
    opening = np.linalg.norm(still[:, upper] - still[:, lower], axis=1)
    return np.asarray(still[opening <= np.quantile(opening, CLOSED)].mean(axis=0))


def symmetric(shape: Floats, chart: dict[str, list[int]]) -> Floats:
    """The shape turned upright and averaged with its mirror image; partners are those of the least total distance."""
    order = chart["order"]
    eyes = shape[order.index(263)] - shape[order.index(33)]
    x = eyes / np.linalg.norm(eyes)
    up = shape[order.index(10)] - shape[order.index(152)]
    y = up - (up @ x) * x
    y /= np.linalg.norm(y)
    upright = (shape - shape[order.index(168)]) @ np.stack([x, y, np.cross(x, y)], axis=1)
    pairs = [i for i, number in enumerate(order) if number not in chart["unpaired"]]
    middle = upright.copy()
    half = upright[pairs]
    mirror = half * [-1.0, 1.0, 1.0]
    for _ in range(5):  # the plane of symmetry and the partners improve each other
        partner = linear_sum_assignment(cdist(mirror, half, "sqeuclidean"))[1]
        fit = best_similarity(mirror, half[partner], np.ones(len(pairs)), scale=False)
        mirror = apply(fit[None], mirror[None])[0]
    if not np.array_equal(partner[partner], np.arange(len(pairs))):
        raise SystemExit("the landmarks do not pair up left and right")
    middle[pairs] = (half + mirror[np.argsort(partner)]) / 2
    return middle


def placed(shape: Floats, face: Face, chart: dict[str, dict[str, int]]) -> dict[int, Floats]:
    """Places on the face by landmark number, mm."""
    order: list[int] = list(chart["order"])
    skin = face.part("skin")
    vertices = skin.vertices.astype(np.float64)
    ties = [(order.index(number), face.sites[site]) for site, number in chart["sites"].items()]
    own = shape[[i for i, _ in ties]]
    target = np.stack([face.part(part).vertices[vertex] for _, (part, vertex) in ties]).astype(np.float64)
    fit = best_similarity(own, target, np.ones(len(ties)), scale=True)
    laid = apply(fit[None], shape[None])[0]
    own = laid[[i for i, _ in ties]]
    warped = laid + RBFInterpolator(own, target - own, kernel="linear", smoothing=0.05)(laid)
    on_skin = nearest_on_surface(warped, vertices, skin.triangles)
    places = dict(zip(order, on_skin, strict=True))
    print(f"landmarks were off the skin by {np.linalg.norm(on_skin - warped, axis=1).mean():.1f} mm in the mean")
    for site, number in chart["sites"].items():
        part, vertex = face.sites[site]
        places[number] = face.part(part).vertices[vertex].astype(np.float64)
    for eye in face.eyes:
        centre, *ring = IRISES[eye.side.lower()]
        ball = face.part(eye.part).vertices.astype(np.float64)
        radius = float((ball[:, 2] - eye.centre[2]).max())
        places[centre] = np.array(eye.centre) + np.array([0.0, 0.0, radius])
        for number in ring:
            away = shape[order.index(number)] - shape[order.index(centre)]
            step = away[:2] / np.linalg.norm(away[:2]) * 6.0  # mm; half the width of an iris
            places[number] = np.array(eye.centre) + np.array([*step, np.sqrt(radius**2 - 36.0)])
    return places


def nearest_on_surface(points: Floats, vertices: Floats, triangles: NDArray[np.int32]) -> Floats:
    """The nearest point of a mesh for each point: exact on the triangles around the 40 nearest centres."""
    corners = vertices[triangles]
    front = corners[(corners[:, :, 2] > -40).all(axis=1)]
    near = cKDTree(front.mean(axis=1)).query(points, k=40)[1]
    best = np.empty_like(points)
    for row, (point, among) in enumerate(zip(points, near, strict=True)):
        candidates = closest_in_triangles(point, front[among])
        best[row] = candidates[np.argmin(np.linalg.norm(candidates - point, axis=1))]
    return best


def closest_in_triangles(point: Floats, corners: Floats) -> Floats:
    """Closest point of each triangle (k, 3, 3): its foot where that lies inside, else the closest on its edges."""
    a, ab, ac = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    aa, cc, abac = (ab * ab).sum(1), (ac * ac).sum(1), (ab * ac).sum(1)
    d1, d2 = ((point - a) * ab).sum(1), ((point - a) * ac).sum(1)
    det = np.maximum(aa * cc - abac**2, 1e-12)
    v, w = (cc * d1 - abac * d2) / det, (aa * d2 - abac * d1) / det
    inside = (v >= 0) & (w >= 0) & (v + w <= 1)
    best = a + v[:, None] * ab + w[:, None] * ac
    distance = np.where(inside, np.linalg.norm(best - point, axis=1), np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        edge = corners[:, j] - corners[:, i]
        along = ((point - corners[:, i]) * edge).sum(1) / np.maximum((edge * edge).sum(1), 1e-12)
        foot = corners[:, i] + np.clip(along, 0, 1)[:, None] * edge
        away = np.linalg.norm(foot - point, axis=1)
        best[away < distance] = foot[away < distance]
        distance = np.minimum(distance, away)
    return best


def write(
    name: str,
    about: str,
    numbers: list[int],
    rigid: list[int],
    names: dict[int, str],
    places: dict[int, Floats],
    chart: dict[str, list[int]],
) -> None:
    """One layout file."""
    lines = [
        "# Written by tools/place_markers.py from tools/markers/*.toml and the default face: do not edit by hand.",
        f'name = "{name}"',
        f'about = "{about}"',
        "",
    ]
    if all(number in numbers for number in chart["scale"]["between"]):
        between = ", ".join(f'"{names[number]}"' for number in chart["scale"]["between"])
        lines += ["[scale]", f"between = [{between}]", f"mm = {chart['scale']['mm']}", ""]
    lines.append("[markers]")
    for number in numbers:
        group = "mouth" if number in chart["mouth"] else "lower" if number in chart["lower"] else "upper"
        place = ", ".join(f"{value + 0.0:.2f}" for value in places[number])
        tail = ", rigid = true" if number in rigid else ""
        lines.append(f'"{names[number]}" = {{ landmark = {number}, group = "{group}", place = [{place}]{tail} }}')
    (ASSETS / f"{name}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{name}: {len(numbers)} markers")


if __name__ == "__main__":
    main()

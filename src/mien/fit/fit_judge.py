"""A fitted head judged by what is seen of it: numbers, each with a bound past which it is a warning or a refusal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core.channels import ARKIT
from mien.core.errors import Note
from mien.face.contact import lip_seam
from mien.face.head_space import head_space
from mien.face.model import Face, Part
from mien.face.surface import edges_of
from mien.face.warps import similarity_between
from mien.fit.head_regions import head_regions

__all__ = ["Finding", "judged"]

Floats = NDArray[np.float64]

_TORN_MM, _TORN_TIMES = 8.0, 3.5  # an edge that grows by more than both is torn
_RAYS = 7
_BOUNDS: dict[str, tuple[str, float, float]] = {
    # what is said, warning and refusal; the worse is above, or below where the warning is larger
    "torn": ("edges of the skin torn by a shape: {:.0f}", 0.5, 200),
    "sides": ("left and right differ by {:.1f} mm in the mean", 4.0, 12.0),
    "upper": ("upper teeth move by {:.2f} mm when the jaw opens", 0.2, np.inf),
    "lower": ("lower teeth bend by {:.2f} mm when the jaw opens", 0.5, np.inf),
    "irises": ("irises seen between the lids: {:.0%}", 0.2, -1.0),
    "lips": ("lips part by {:.0f} mm at full jaw", 8.0, 2.0),
    "shut": ("lips stay {:.1f} mm apart over an open jaw", 1.5, np.inf),
    "lids": ("lids are {:.1f} mm apart at rest", 3.0, -1.0),
    "blink": ("lids stay {:.1f} mm apart in a blink", 1.0, np.inf),
}


@dataclass(frozen=True)
class Finding:
    """One number of the judgement; ``kind`` is "good", "warning" or "refusal"."""

    name: str
    value: float
    kind: str

    @property
    def words(self) -> str:
        """What it says."""
        return _BOUNDS[self.name][0].format(self.value)

    @property
    def note(self) -> Note:
        """The same as a note of a report."""
        return Note("note" if self.kind == "good" else "warning", self.words)


def judged(face: Face, skin: Floats, lip_gap: float, lid_gap: float) -> tuple[Finding, ...]:
    """Judge a fitted head.

    Parameters
    ----------
    face : Face
    skin : ndarray, shape (n, 3)
        The default skin bent onto it, mm.
    lip_gap, lid_gap : float
        What is left between lips and lids that should meet, mm; NaN where there are none.
    """
    found = {
        "torn": float(_torn(face.part("skin"))),
        "sides": _sides(skin),
        "upper": _most(face, ("own_upper", "teeth_upper"), _moved),
        "lower": _most(face, ("own_lower", "teeth_lower"), _bent),
        "irises": _irises(face),
        "lips": _lips_part(face, skin),
        "shut": max(lip_gap, 0.0),
        "lids": _lids(skin),
        "blink": max(lid_gap, 0.0),
    }
    return tuple(Finding(name, value, _kind(name, value)) for name, value in found.items() if not np.isnan(value))


def _kind(name: str, value: float) -> str:
    _, warning, refusal = _BOUNDS[name]
    past = value > warning if warning < refusal else value < warning
    beyond = value > refusal if warning < refusal else value < refusal
    return "refusal" if beyond else "warning" if past else "good"


def _torn(skin: Part) -> int:
    """Edges that some ARKit shape makes far longer."""
    edges = edges_of(skin.triangles)
    rest = skin.vertices.astype(np.float64)
    before = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    torn = np.zeros(len(edges), dtype=np.bool_)
    for name in ARKIT:
        target = skin.targets.get(name)
        if target is not None and name != "mouthClose":  # (made to be added to an open jaw)
            moved = rest.copy()
            moved[target.vertices] += target.offsets
            after = np.linalg.norm(moved[edges[:, 0]] - moved[edges[:, 1]], axis=1)
            torn |= (after - before > _TORN_MM) & (after > _TORN_TIMES * before)
    return int(torn.sum())


def _sides(skin: Floats) -> float:
    """Mean distance of the face from its mirror image, beyond what the default's own sides differ by."""
    from scipy.spatial import cKDTree

    space, regions = head_space(), head_regions()
    chosen = np.flatnonzero(sum(regions[key] for key in ("mouth", "eyes", "nose", "cheeks and jaw")))
    mate = cKDTree(space.rest).query(space.rest[chosen] * [-1, 1, 1])[1]
    one, other = skin[chosen], skin[mate] * [-1, 1, 1]
    return float(np.linalg.norm(similarity_between(other, one, scaled=False)(other) - one, axis=1).mean())


def _most(face: Face, names: tuple[str, ...], measure) -> float:  # type: ignore[no-untyped-def]
    values = [measure(part) for part in face.parts if part.name in names]
    return max(values, default=float("nan"))


def _moved(part: Part) -> float:
    return max((float(np.abs(t.offsets).max()) for n, t in part.targets.items() if n == "jawOpen"), default=0.0)


def _bent(part: Part) -> float:
    """Largest distance from a rigid motion in jawOpen."""
    target = part.targets.get("jawOpen")
    if target is None:
        return float("nan")
    rest = part.vertices.astype(np.float64)
    posed = rest.copy()
    posed[target.vertices] += target.offsets
    return float(np.linalg.norm(similarity_between(rest, posed, scaled=False)(rest) - posed, axis=1).max())


def _lids(skin: Floats) -> float:
    """The smaller eye's opening."""
    space = head_space()
    return float(min(np.ptp(skin[loop][:, 1]) for loop in (space.lid_loop_left, space.lid_loop_right)))


def _lips_part(face: Face, skin: Floats) -> float:
    """How far the lips part at full jaw beyond rest, mm: the default's lips bent onto the head; NaN without a jaw."""
    target = face.part("skin").targets.get("jawOpen")
    if target is None:
        return float("nan")
    from scipy.spatial import cKDTree

    part = face.part("skin")
    moves = np.zeros((len(part.vertices), 3))
    moves[target.vertices] = target.offsets
    lips = lip_seam()
    tree = cKDTree(part.vertices)
    upper, lower = (moves[tree.query(half @ skin)[1], 1] for half in (lips.upper, lips.lower))
    return float(np.percentile(upper - lower, 95))


def _irises(face: Face) -> float:
    """Share of the irises that a look from the front sees; the worse eye."""
    shares = []
    others = [part for part in face.parts if part.name not in {eye.part for eye in face.eyes}]
    corners = np.concatenate([part.vertices[part.triangles] for part in others]).astype(np.float64)
    for eye in face.eyes:
        ball = face.part(eye.part).vertices
        centre = np.array(eye.centre)
        radius = float(np.median(np.linalg.norm(ball - centre, axis=1)))
        step = np.linspace(-0.4, 0.4, _RAYS) * radius
        x, y = (grid.ravel() for grid in np.meshgrid(step, step))
        inside = x**2 + y**2 <= (0.42 * radius) ** 2
        points = np.stack([x, y, np.sqrt(radius**2 - x**2 - y**2)], axis=1)[inside] + centre
        shares.append(float((~_hidden(points, corners)).mean()))
    return min(shares, default=float("nan"))


def _hidden(points: Floats, corners: Floats) -> NDArray[np.bool_]:
    """Whether a triangle lies before each point, looked at along -z."""
    low, high = points.min(0), points.max(0)
    near = ((corners[:, :, :2].max(1) >= low[:2]) & (corners[:, :, :2].min(1) <= high[:2])).all(1)
    some = corners[near & (corners[:, :, 2].max(1) > low[2])]
    a, b, c = some[:, 0], some[:, 1], some[:, 2]
    hidden = np.zeros(len(points), dtype=np.bool_)
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    some_area = np.where(np.abs(area) > 1e-12, area, np.inf)
    for number, (x, y, z) in enumerate(points):
        u = ((b[:, 0] - x) * (c[:, 1] - y) - (b[:, 1] - y) * (c[:, 0] - x)) / some_area
        v = ((c[:, 0] - x) * (a[:, 1] - y) - (c[:, 1] - y) * (a[:, 0] - x)) / some_area
        w = 1 - u - v
        depth = u * a[:, 2] + v * b[:, 2] + w * c[:, 2]
        hit = (u >= 0) & (v >= 0) & (w >= 0) & np.isfinite(some_area) & (depth > z + 0.5)
        hidden[number] = bool(hit.any())
    return hidden

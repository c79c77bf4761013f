"""Teeth and gums: single teeth set along an arch. Sizes in millimetres after common dental means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from makehuman import Floats, Ints
from sculpt import Sculpt, smoothstep

# Width and height of each crown from the middle to the back (Wheeler's averages, rounded), and its thickness.
_UPPER = (
    (8.5, 10.2, 3.4),
    (6.6, 9.0, 3.2),
    (7.5, 9.8, 4.2),
    (7.0, 8.2, 6.5),
    (6.8, 7.8, 6.5),
    (9.6, 7.0, 8.0),
    (9.0, 6.6, 8.0),
)
_LOWER = (
    (5.2, 8.8, 3.0),
    (5.8, 9.0, 3.0),
    (6.8, 9.8, 4.0),
    (6.9, 8.4, 5.5),
    (7.0, 7.8, 6.0),
    (10.2, 7.2, 8.0),
    (9.8, 7.0, 8.0),
)
_AROUND, _UP = 20, 10
_ENAMEL, _ROOT, _GUM = np.array([0.97, 0.945, 0.89]), np.array([0.93, 0.87, 0.76]), np.array([0.70, 0.36, 0.36])


@dataclass(frozen=True)
class Row:
    """Where a row of teeth stands: z of its front, y of the middle incisors' edge, half width and depth of the arch."""

    name: str
    front: float
    edge: float
    half_width: float
    depth: float

    @property
    def upper(self) -> bool:
        """True for the upper row, whose crowns hang down."""
        return self.name == "teeth_upper"


class _Arch:
    """A half ellipse, walked by length from its middle (positive to the speaker's left)."""

    def __init__(self, row: Row) -> None:
        angle = np.linspace(-1.75, 1.75, 3001)
        x, z = row.half_width * np.sin(angle), row.front - row.depth * (1 - np.cos(angle))
        self._points = np.stack([x, z], axis=1)
        along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(self._points, axis=0), axis=1))]
        self._along = along - along[-1] / 2

    def at(self, length: float) -> tuple[Floats, Floats, Floats]:
        """Place, unit tangent and outward unit normal in x, y, z (y = 0)."""

        def place(s: float) -> Floats:
            return np.array([np.interp(s, self._along, self._points[:, k]) for k in range(2)])

        x, z = place(length)
        dx, dz = place(length + 0.2) - place(length - 0.2)
        step = np.hypot(dx, dz)
        return np.array([x, 0, z]), np.array([dx, 0, dz]) / step, np.array([-dz, 0, dx]) / step


def build_row(row: Row) -> Sculpt:
    """One row of fourteen teeth in its gum."""
    arch = _Arch(row)
    sizes = _UPPER if row.upper else _LOWER
    points: list[Floats] = []
    triangles: list[Ints] = []
    colours: list[Floats] = []
    borders = np.r_[0, np.cumsum([size[0] for size in sizes])]
    count = 0
    for side in (-1, 1):
        for place, (width, height, thickness) in enumerate(sizes):
            crown, faces = _crown(width, height, thickness, place)
            base, tangent, outward = arch.at(side * (borders[place] + width / 2))
            up = 1.0 if row.upper else -1.0
            edge = row.edge + up * (0.5 if place == 1 and row.upper else -0.075 * max(place - 2, 0))
            shape = base + crown[:, :1] * tangent + (crown[:, 2:] - thickness * 0.5) * outward
            shape[:, 1] = edge + up * crown[:, 1]
            points.append(shape)
            triangles.append((faces if row.upper else faces[:, ::-1]) + count)
            root = smoothstep(0.45, 1.0, crown[:, 1] / height)[:, None]
            colours.append((_ENAMEL + (_ROOT - _ENAMEL) * root * 0.7) * (1 - 0.03 * place))
            count += len(shape)
    gum, faces, paint = _gum(row, arch, borders, sizes)
    points.append(gum)
    triangles.append(faces + count)
    colours.append(paint)
    vertices = np.vstack(points)
    depth = smoothstep(row.front - 42, row.front - 2, vertices[:, 2])[:, None]
    return Sculpt(row.name, vertices, np.vstack(triangles), colours=np.vstack(colours) * (0.55 + 0.45 * depth))


def _crown(width: float, height: float, thickness: float, place: int) -> tuple[Floats, Ints]:
    """A crown: x along the arch, y from the biting edge (0) to the neck (height), z outward from its middle."""
    level = np.linspace(0, 1, _UP) ** 1.3
    around = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    h, a = np.meshgrid(level, around, indexing="ij")
    molar = place >= 3
    slim = 0.80 + 0.20 * (1 - h) ** 0.7 if not molar else 0.90 + 0.10 * (1 - h)
    cut = np.minimum(1, (h / 0.10 + 0.55)) if not molar else np.minimum(1, h / 0.3 + 0.6)
    thick = (0.38 + 0.62 * np.minimum(1, h / 0.65)) if not molar else np.ones_like(h)
    power = 0.55

    def rounded(v: Floats) -> Floats:
        return np.sign(v) * np.abs(v) ** power

    x = 0.5 * (width - 0.12) * slim * np.minimum(cut, 1) * rounded(np.cos(a))
    z = 0.5 * thickness * thick * cut * rounded(np.sin(a))
    z = z + thickness * 0.5 * (1 - thick * cut) * 0.75 + 0.35 * np.sin(np.pi * np.clip(h, 0, 1)) * (np.sin(a) > 0)
    drop = 0.35 if place == 2 else 0.12
    y = height * h + drop * (2 * x / width) ** 2 * (1 - h)
    points = np.stack([x, y, z], axis=2).reshape(-1, 3)
    tip = np.array([[0, 0.0, points[:_AROUND, 2].mean()]])
    ring = np.arange(_AROUND)
    following = np.roll(ring, -1)
    faces = [np.stack([np.full(_AROUND, len(points)), ring, following], axis=1)]
    for k in range(_UP - 1):
        p, q = k * _AROUND + ring, k * _AROUND + following
        faces += [np.stack([p, p + _AROUND, q], axis=1), np.stack([q, p + _AROUND, q + _AROUND], axis=1)]
    return np.vstack([points, tip]), np.vstack(faces)


def _gum(
    row: Row, arch: _Arch, borders: Floats, sizes: tuple[tuple[float, float, float], ...]
) -> tuple[Floats, Ints, Floats]:
    """A strip over the necks of the teeth with papillae between them."""
    steps = np.linspace(-borders[-1], borders[-1], 14 * 8 + 1)
    profile = 8
    up = 1.0 if row.upper else -1.0
    points = []
    for s in steps:
        base, _, outward = arch.at(float(s))
        place = int(np.clip(np.searchsorted(borders, abs(s), side="right") - 1, 0, 6))
        width, height, thickness = sizes[place]
        share = (abs(s) - borders[place]) / width
        neck = height * 0.86 - 1.9 * abs(2 * share - 1) ** 2.5
        for k in range(profile):
            turn = k / (profile - 1)
            rise = neck + 9.0 * turn**1.2 if k else neck
            bulge = 0.15 + 1.3 * np.sin(np.pi * min(turn * 0.8 + 0.06, 1.0))
            point = base + (bulge - 1.0 * max(0.0, 1 - turn * 5) - 0.25) * outward
            point[1] = row.edge + up * rise
            points.append(point)
        inner = base - (thickness + 2.0) * outward
        for lift in (9.0, 0.0):
            back = inner.copy()
            back[1] = row.edge + up * (height * 0.75 + lift)
            points.append(back)
    profile += 2
    faces = []
    ring = np.arange(profile)
    for i in range(len(steps) - 1):
        a, b = i * profile + ring, i * profile + np.roll(ring, -1)
        c, d = a + profile, b + profile
        quads = [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
        faces += quads if row.upper else [q[:, ::-1] for q in quads]
    vertices = np.array(points)
    return vertices, np.vstack(faces), np.tile(_GUM, (len(vertices), 1))

"""Glasses and hair over the forehead are noticed; a face lit from one side has neither."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageDraw

from mien.face.head_space import head_space
from mien.fit.photo_obstacles import obstacles
from tests.fit.test_photos import HEIGHT, WIDTH, camera


def told(picture: Image.Image) -> list[str]:
    notes = obstacles(head_space(), head_space().rest, np.asarray(picture), camera(0.0), "a.png")
    return [note.message for note in notes]


@pytest.fixture
def bare() -> Image.Image:
    """Skin under a lamp at one side, which makes the other half half as light."""
    shade = np.linspace(1.0, 0.5, WIDTH)[None, :, None] * np.array([190, 140, 120.0])
    return Image.fromarray(np.broadcast_to(shade, (HEIGHT, WIDTH, 3)).astype(np.uint8))


def test_a_bare_face_has_nothing_before_it(bare: Image.Image) -> None:
    assert told(bare) == []


def test_a_fringe(bare: Image.Image) -> None:
    x, y, _ = head_space().rest.T
    places = camera(0.0).seen(head_space().rest[head_space().outer() & (y > 30) & (y < 70) & (abs(x) < 50)])[0]
    ImageDraw.Draw(bare).rectangle([*places.min(0), *places.max(0)], fill=(60, 45, 35))
    (only,) = told(bare)
    assert "hair or a hat covers" in only


def test_glasses(bare: Image.Image) -> None:
    draw, middles = ImageDraw.Draw(bare), []
    for loop in (head_space().lid_loop_left, head_space().lid_loop_right):
        places = camera(0.0).seen(head_space().rest[loop])[0]
        (x, y), reach = places.mean(0), 0.85 * np.ptp(places[:, 0])
        draw.ellipse([x - reach, y - 0.8 * reach, x + reach, y + 0.9 * reach], outline=(25, 20, 25), width=5)
        middles.append((x, y))
    assert told(bare) == []  # rims alone may be shadows
    draw.line(middles, fill=(25, 20, 25), width=5)
    (only,) = told(bare)
    assert "glasses" in only

"""One face, made whole; the contract over all of the cast is ``benchmarks/cast.py``."""

from functools import cache

import numpy as np

from mien.face.cast.made_person import person_named
from mien.face.cast.making import make_face
from mien.face.default_face import default_face
from mien.face.folds import folds_of
from mien.face.model import Face
from mien.face.posing import Poser


@cache
def _kofi() -> Face:
    return make_face(person_named("kofi"))  # of age, with a beard


def test_it_has_every_shape_part_and_site_of_the_default_face() -> None:
    face, own = _kofi(), default_face()
    assert set(face.part("skin").targets) == set(own.part("skin").targets)
    names = {part.name for part in face.parts}
    assert names >= {part.name for part in own.parts} - {"hair", "hair_clumps"}
    assert {"hair", "hair_cap", "beard", "tears"} <= names
    assert face.sites == own.sites
    assert all(np.isfinite(part.vertices).all() for part in face.parts)


def test_lips_that_should_meet_meet_and_the_beard_goes_with_the_jaw() -> None:
    face = _kofi()
    names = ("jawOpen", "mouthClose")
    poser = Poser(face, names)
    skin = [part.name for part in face.parts].index("skin")
    beard = [part.name for part in face.parts].index("beard")
    upper, lower = (face.sites[f"lip_{which}_inner"][1] for which in ("upper", "lower"))

    def gap(row: list[float]) -> float:
        points = poser.pose(row).parts[skin].vertices
        return float(np.linalg.norm(points[upper] - points[lower]))

    assert gap([0, 0]) < 1.2
    assert gap([0.6, 0.6]) < 1.2
    assert gap([0.6, 0]) > 8
    moved = poser.pose([1, 0]).parts[beard].vertices - poser.pose([0, 0]).parts[beard].vertices
    assert np.linalg.norm(moved, axis=1).max() > 15


def test_its_folds_are_deeper_than_the_defaults() -> None:
    own, older = default_face().part("skin"), _kofi().part("skin")
    sizes = np.array([[0, 2048, 2048]], dtype=np.int32)
    one, other = folds_of(own, sizes), folds_of(older, sizes)
    assert one is not None
    assert other is not None
    assert np.abs(other.folds[0].shade).max() > 1.1 * np.abs(one.folds[0].shade).max()

import numpy as np

from mien.face.cast.made_person import looks
from mien.face.cast.scalp import beard_growth, brow_growth, hair_growth

CROWN, FOREHEAD, CHIN, ABOVE_LIP, BROW = (
    np.array([place], float) for place in ((0, 105, -75), (0, 45, 25), (0, -92, 22), (8, -53, 33), (28, 18.5, 22))
)


def test_hair_grows_on_the_crown_and_not_on_the_forehead() -> None:
    for name, cut in looks()["cuts"].items():
        assert hair_growth(FOREHEAD, cut)[0] == 0, name
        assert hair_growth(CROWN, cut)[0] == (0 if "bald" in cut else 1), name


def test_beards_grow_where_they_are_named_after() -> None:
    beards = looks()["beards"]
    assert beard_growth(CHIN, beards["full"])[0] > 0.5
    assert beard_growth(ABOVE_LIP, beards["moustache"])[0] > 0.5
    assert beard_growth(CHIN, beards["moustache"])[0] == 0
    assert beard_growth(FOREHEAD, beards["full"])[0] == 0


def test_brows_grow_over_the_eyes() -> None:
    assert brow_growth(BROW)[0] > 0.5
    assert brow_growth(CHIN)[0] == 0

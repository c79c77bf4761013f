from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mien.core.errors import InputError
from mien.core.plotting import COLOURS, GRID, PAPER
from mien.inspection.coverage_picture import draw_coverage
from mien.inspection.curve_pictures import draw_curves, draw_fitting_cost, most_heard, read_sequence
from mien.inspection.influence_picture import draw_influence, evenly_spoken
from mien.inspection.key_shape_sheets import KeyShapes
from mien.inspection.performer_pictures import pictures_of
from mien.motion.mouth.articulation import articulation_table
from tests.inspection.performers import known_performer, small_performer


def pixels(image: Image.Image) -> np.ndarray:
    return np.asarray(image).astype(int)


def heights(image: Image.Image, column: int, colour: tuple[int, int, int]) -> np.ndarray:
    """Rows in which a column of pixels shows a colour."""
    return np.flatnonzero(np.abs(pixels(image)[:, column] - colour).max(axis=1) < 40)


def height(image: Image.Image, column: int, colour: tuple[int, int, int]) -> float:
    """Where a curve crosses a column; the legend above is left out."""
    rows = heights(image, column, colour)
    return float(rows[rows > 40].mean())


def test_curves_run_where_their_polynomials_do():
    image = draw_curves(known_performer().coarticulation, [("P", "AA")])
    start, end = COLOURS[1], COLOURS[0]
    low, high = height(image, 50, end), height(image, 50, start)  # near t = 0: F_s = 1 above F_e = 0
    quarter = 44 + (320 - 44) // 4
    assert high < low
    assert height(image, quarter, start) == pytest.approx(high + (low - high) / 4, abs=4)
    assert height(image, quarter, end) == pytest.approx(low - (low - high) / 4, abs=4)


def test_a_diphone_never_heard_is_drawn_with_its_classes():
    paper = known_performer().coarticulation
    classes = draw_curves(paper, [("M", "T")])  # closed, tongue_on_ridge: the line again
    own = draw_curves(paper, [("P", "AA")])
    assert (pixels(classes)[75:] == pixels(own)[75:]).all()  # all but the title
    assert (pixels(classes)[50:75] != pixels(own)[50:75]).any()


def test_curves_that_were_not_learned_are_refused():
    paper = known_performer().coarticulation
    with pytest.raises(InputError, match=r"UW AA .* cosine interpolation of key shapes would be used"):
        draw_curves(paper, [("UW", "AA")])
    with pytest.raises(InputError, match=r"P AA T .* its diphones would be used"):
        draw_curves(paper, [("P", "AA", "T")])
    with pytest.raises(InputError, match="nothing to draw"):
        draw_curves(paper, [])
    with pytest.raises(InputError, match="two or three phones"):
        read_sequence("P")
    with pytest.raises(InputError, match="unknown phone 'XX'"):
        read_sequence("P XX")


def test_most_heard_puts_pauses_last():
    paper = small_performer().coarticulation
    found = most_heard(paper, 2, count=500)
    counts = [paper.curves_[labels].pairs for labels in found]
    spoken = ["SIL" not in labels for labels in found]
    assert spoken == sorted(spoken, reverse=True)
    assert counts[: sum(spoken)] == sorted(counts[: sum(spoken)], reverse=True)
    assert {len(labels) for labels in most_heard(paper, 3)} <= {3}


def test_cost_is_drawn_on_a_logarithmic_axis():
    cost = np.array([[10.0] * 6, [100.0] * 6, [1000.0] * 6, [1000.0] * 6])
    image = draw_fitting_cost(replace(small_performer(), fitting_cost=cost))
    low, middle, high = (height(image, 300, colour) for colour in ((30, 30, 34), COLOURS[1], COLOURS[0]))
    assert high < middle < low
    assert low - middle == pytest.approx(middle - high, abs=1.5)


def test_coverage_has_a_colour_for_each_kind():
    picture = pixels(draw_coverage(known_performer().motion.coverage_))
    order = [phone for members in articulation_table().visemes.values() for phone in members] + ["SIL"]

    def corner(first: str, second: str) -> tuple[int, ...]:
        x, y = 150 + 22 * order.index(second) + 4, 132 + 22 * order.index(first) + 4
        return tuple(picture[y, x].tolist())

    often, rare = corner("L", "UW"), corner("UW", "AA")
    assert often[2] > often[0] + 50  # blue
    assert sum(corner("B", "L")) > sum(often) + 200  # the less, the paler
    assert rare[0] > rare[2] + 40  # orange
    assert corner("M", "T") == (235, 235, 238)  # like B L
    assert corner("AA", "AA") == PAPER


def test_influence_picture_shows_every_phone_in_its_colour():
    motion = small_performer().motion
    image = draw_influence(motion, "maybe")
    panel = pixels(image)[84:204]
    for colour in COLOURS[:5]:  # M EY.1 EY.2 B IY
        assert (np.abs(panel - colour).max(axis=2) < 30).sum() > 100
    assert (np.abs(panel - GRID).max(axis=2) < 8).sum() > 100
    assert (pixels(draw_influence(motion, "maybe")) == pixels(image)).all()
    tier = evenly_spoken("maybe")
    assert [phone.label for phone in tier] == ["SIL", "M", "EY", "B", "IY", "SIL"]
    assert tier.intervals[1].duration == pytest.approx(0.1)


@pytest.fixture(scope="module")
def shapes() -> KeyShapes:
    return KeyShapes(small_performer())


def test_key_shapes_of_the_speaker_open_and_close(shapes):
    from mien.core import channels

    found, jaw = shapes.of_speaker(), channels.ALL.index("jawOpen")
    assert set(found) == set(articulation_table().symbols)
    assert found["AA"][jaw] > found["B"][jaw] + 0.02
    hand_made = shapes.of_face()
    assert list(hand_made) == list(found)
    assert hand_made["AA"][jaw] > hand_made["B"][jaw] + 0.1


def test_classes_have_one_shape_each(shapes):
    found = shapes.of_classes()
    assert len(found) == 14
    assert "closed: P B M" in found
    sheet = shapes.sheet({"closed": found["closed: P B M"], "pause": found["pause"]})
    assert sheet.size[0] > 2 * 230


def test_which_pictures_there_are():
    names = [name for name, _ in pictures_of(known_performer())]
    rest = ["fitting-cost.png", "coverage.png", "influence.png", "expressions-hand-made.png"]
    sheets = ["key-shapes-speaker.png", "key-shapes-face.png", "key-shapes-classes.png"]
    assert names == ["diphones.png", "triphones.png", *rest, *sheets]
    asked = [name for name, _ in pictures_of(known_performer(), ["SIL B L"], "blue")]
    assert asked == ["triphones.png", *rest, *sheets]
    with pytest.raises(InputError, match="no curves were learned"):
        pictures_of(known_performer(), ["UW AA"])
    with pytest.raises(InputError, match="empty"):
        pictures_of(known_performer(), word=" ")

"""The default face does what speech and expression ask of it: measured on the mesh, not on pictures."""

from collections.abc import Callable

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from mien.core.channels import ARKIT, BEYOND_ARKIT, WEIGHTS
from mien.face.library import load_face
from mien.face.model import Face, Part
from mien.face.posing import Poser

Floats = NDArray[np.floating]
SIDES = ("Left", "Right")
INNER_PAIRS = ["", *(f"_{side}{step}" for side in "lr" for step in (1, 2, 3))]
CLOSED_MOUTH = (
    "mouthPucker",
    "mouthLeft",
    "mouthSmileLeft",
    "mouthFrownLeft",
    "mouthDimpleLeft",
    "mouthStretchLeft",
    "mouthPressLeft",
    "mouthRollLower",
    "mouthShrugLower",
    "jawLeft",
    "cheekPuff",
    "mouthSharpPullLeft",
    "mouthTightenLeft",
    "nasolabialDeepenLeft",
    "noseFlareLeft",
    "noseCompressLeft",
)
# The lips together for /p b m/: what the talking mouth uses, and the same with the jaw ajar.
CLOSURES = (
    {"mouthClose": 0.05, "jawOpen": 0.05, "mouthPressLeft": 0.3, "mouthPressRight": 0.3},
    {"mouthClose": 0.3, "jawOpen": 0.3},
    {"mouthClose": 1.0, "jawOpen": 1.0},
    {"mouthClose": 0.1, "jawOpen": 0.1, "mouthRollLower": 0.3, "mouthRollUpper": 0.3},
)


@pytest.fixture(scope="module")
def face() -> Face:
    return load_face("default")


@pytest.fixture(scope="module")
def posed(face: Face) -> Callable[..., dict[str, Floats]]:
    names = WEIGHTS
    poser = Poser(face, names)

    def pose(**weights: float) -> dict[str, Floats]:
        row = np.array([weights.get(name, 0.0) for name in names])
        return {
            part.name: posed.vertices.astype(float)
            for part, posed in zip(face.parts, poser.pose(row).parts, strict=True)
        }

    return pose


def both(name: str, weight: float = 1.0) -> dict[str, float]:
    return {name + side: weight for side in SIDES}


@njit(cache=False)
def _cover(height: Floats, corners: Floats, x0: float, y0: float, cell: float) -> None:
    rows, columns = height.shape
    for a, b, c in corners:
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if abs(area) < 1e-9:
            continue
        for row in range(max(0, int((min(a[1], b[1], c[1]) - y0) / cell)), rows):
            y = y0 + row * cell
            if y > max(a[1], b[1], c[1]):
                break
            for column in range(max(0, int((min(a[0], b[0], c[0]) - x0) / cell)), columns):
                x = x0 + column * cell
                if x > max(a[0], b[0], c[0]):
                    break
                u = ((b[0] - x) * (c[1] - y) - (c[0] - x) * (b[1] - y)) / area
                v = ((c[0] - x) * (a[1] - y) - (a[0] - x) * (c[1] - y)) / area
                if u >= 0 and v >= 0 and u + v <= 1:
                    height[row, column] = max(height[row, column], u * a[2] + v * b[2] + (1 - u - v) * c[2])


def front_view(
    points: Floats, triangles: NDArray[np.int32], cell: float, box: tuple[float, float, float, float]
) -> Floats:
    """Greatest z over a grid of x (columns) and y (rows), -inf where nothing is."""
    x0, x1, y0, y1 = box
    height = np.full((len(np.arange(y0, y1, cell)), len(np.arange(x0, x1, cell))), -np.inf)
    _cover(height, points[triangles], x0, y0, cell)
    return height


def in_front(
    face: Face, shape: dict[str, Floats], part: str, box: tuple[float, float, float, float], cell: float
) -> Floats:
    """Where a part stands before the skin in a view from straight ahead: boolean grid."""
    heights = [front_view(shape[name], face.part(name).triangles, cell, box) for name in (part, "skin")]
    return np.asarray(heights[0] > heights[1])


def lip_gaps(face: Face, skin: Floats) -> Floats:
    """Distance, mm, up from the lower to the upper lip at seven pairs of places of the inner lips."""
    return np.array(
        [
            skin[face.sites["lip_upper_inner" + pair][1], 1] - skin[face.sites["lip_lower_inner" + pair][1], 1]
            for pair in INNER_PAIRS
        ]
    )


def mouth_box(face: Face, skin: Floats) -> tuple[float, float, float, float]:
    y = skin[face.sites["lip_upper_inner"][1], 1]
    return (-30.0, 30.0, y - 35.0, y + 18.0)


def seen_teeth(face: Face, shape: dict[str, Floats]) -> float:
    """Square millimetres of teeth, gums and tongue that stand before the skin."""
    box = mouth_box(face, shape["skin"])
    parts = ("teeth_upper", "teeth_lower", "tongue")
    return float(np.any([in_front(face, shape, part, box, 0.5) for part in parts], axis=0).sum() * 0.25)


def test_every_channel_of_arkit_moves_something(face: Face) -> None:
    moved = {name for part in face.parts for name in part.targets}
    assert set(ARKIT) - moved == set()
    assert set(BEYOND_ARKIT) - moved == set()
    assert moved <= set(WEIGHTS)


def test_eyes_turn_rigidly_and_carry_no_targets(face: Face) -> None:
    assert {eye.side for eye in face.eyes} == set(SIDES)
    for eye in face.eyes:
        assert not face.part(eye.part).targets
        assert all(10 <= turn <= 45 for turn in (eye.look_up, eye.look_down, eye.look_in, eye.look_out))
        radius = np.linalg.norm(face.part(eye.part).vertices - np.array(eye.centre), axis=1)
        assert np.ptp(radius) < 0.08 * radius.mean()
    assert np.allclose(np.mean([eye.centre for eye in face.eyes], axis=0), 0, atol=0.01)


def test_nothing_is_undefined_or_out_of_scale(face: Face) -> None:
    for part in face.parts:
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert 0 <= part.head_weight.min() <= part.head_weight.max() <= 1
        assert np.abs(part.vertices).max() < 320
        for target in part.targets.values():
            assert np.isfinite(target.offsets).all()
            assert np.abs(target.offsets).max() < 60


def test_budget(face: Face) -> None:
    assert len(face.part("skin").vertices) <= 28_000
    assert sum(len(part.vertices) for part in face.parts) <= 75_000


@pytest.mark.parametrize("name", ["skin", "teeth_upper", "teeth_lower", "tongue", "eye_left", "eye_right"])
def test_surfaces_are_wound_outward(face: Face, name: str) -> None:
    """Seen from straight ahead the nearest triangle faces the viewer."""
    part = face.part(name)
    points = part.vertices.astype(float)
    corners = points[part.triangles]
    towards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0
    low, high = points.min(0) - 1, points.max(0) + 1
    cell = float(high[0] - low[0]) / 60
    views = [
        front_view(points, part.triangles[side], cell, (low[0], high[0], low[1], high[1]))
        for side in (towards, ~towards)
    ]
    covered = np.isfinite(views[0]) | np.isfinite(views[1])
    assert (views[0] > views[1])[covered].mean() > 0.98


def _mirror_of(part: Part) -> tuple[NDArray[np.int64], Floats]:
    from scipy.spatial import cKDTree

    distance, partner = cKDTree(part.vertices).query(part.vertices * np.array([-1, 1, 1]))
    return partner, distance


def _dense(part: Part, name: str) -> Floats:
    offsets = np.zeros((len(part.vertices), 3))
    if name in part.targets:
        offsets[part.targets[name].vertices] = part.targets[name].offsets
    return offsets


@pytest.mark.parametrize("left", [name for name in WEIGHTS if "Left" in name])
def test_pairs_of_channels_mirror_each_other(face: Face, left: str) -> None:
    skin = face.part("skin")
    partner, distance = _mirror_of(skin)
    sure = distance < 0.05
    assert sure.mean() > 0.97
    mirrored = _dense(skin, left.replace("Left", "Right"))[partner] * np.array([-1, 1, 1])
    difference = np.abs(_dense(skin, left) - mirrored)[sure].max(axis=1)
    assert np.quantile(difference, 0.995) < 0.15
    assert difference.max() < 1.0


def test_lips_touch_at_rest_without_crossing(face: Face, posed: Callable[..., dict[str, Floats]]) -> None:
    gaps = lip_gaps(face, posed()["skin"])
    assert gaps.max() <= 0.5
    assert gaps.min() > -0.4
    assert seen_teeth(face, posed()) == 0


@pytest.mark.parametrize("weights", CLOSURES, ids=lambda w: "+".join(f"{k}={v:g}" for k, v in w.items()))
def test_closures_show_nothing_between_the_lips(
    face: Face, posed: Callable[..., dict[str, Floats]], weights: dict[str, float]
) -> None:
    shape = posed(**weights)
    assert seen_teeth(face, shape) == 0
    assert lip_gaps(face, shape["skin"]).max() <= 0.5


@pytest.mark.parametrize("name", CLOSED_MOUTH)
@pytest.mark.parametrize("weight", [0.5, 1.0])
def test_shapes_of_a_closed_mouth_keep_it_closed(
    face: Face, posed: Callable[..., dict[str, Floats]], name: str, weight: float
) -> None:
    pairs = {name: weight} | (
        {name.replace("Left", "Right"): weight} if name.startswith(("mouth", "nas", "nos")) else {}
    )
    weights = {name: weight} if name in ("mouthLeft", "jawLeft") else pairs
    assert seen_teeth(face, posed(**weights)) <= 1.0


def test_jaw_opens_the_mouth_and_carries_teeth_and_chin(face: Face, posed: Callable[..., dict[str, Floats]]) -> None:
    rest, wide = posed(), posed(jawOpen=1.0)
    assert lip_gaps(face, wide["skin"])[0] > 20
    chin = face.sites["chin"][1]
    assert rest["skin"][chin, 1] - wide["skin"][chin, 1] > 15
    assert (rest["teeth_lower"][:, 1] - wide["teeth_lower"][:, 1]).max() > 15
    assert np.abs(rest["teeth_upper"] - wide["teeth_upper"]).max() < 0.05


def test_upper_teeth_show_when_the_lips_part(face: Face, posed: Callable[..., dict[str, Floats]]) -> None:
    shape = posed(jawOpen=0.25, **both("mouthSmile", 0.6))
    shown = in_front(face, shape, "teeth_upper", mouth_box(face, shape["skin"]), 0.5)
    assert shown.sum() * 0.25 > 40
    middle = shown[:, shown.shape[1] // 2 - 4 : shown.shape[1] // 2 + 4].sum(axis=0) * 0.5
    assert middle.mean() >= 1.5


def test_lower_lip_reaches_the_upper_teeth_for_f(face: Face, posed: Callable[..., dict[str, Floats]]) -> None:
    shape = posed(jawOpen=0.02, mouthRollLower=0.85, mouthShrugLower=0.1, **both("mouthUpperUp", 0.3))
    edge = shape["teeth_upper"][np.abs(shape["teeth_upper"][:, 0]) < 7]
    edge = edge[edge[:, 2] > edge[:, 2].max() - 4]
    lip = shape["skin"][face.sites["lip_lower_inner"][1]]
    assert lip[1] >= edge[:, 1].min() - 0.6
    assert 0 <= lip[2] - edge[np.argmin(edge[:, 1]), 2] < 7


@pytest.mark.parametrize(
    "weights",
    [
        {},
        both("mouthSmile"),
        {"mouthFunnel": 1.0},
        {"mouthPucker": 1.0},
        {"jawOpen": 1.0},
        both("mouthStretch"),
        both("mouthFrown"),
        {"mouthRollLower": 1.0},
        {"mouthRollUpper": 1.0},
        both("mouthPress"),
    ],
    ids=lambda w: "+".join(w) or "rest",
)
def test_teeth_stay_behind_the_lips(
    face: Face, posed: Callable[..., dict[str, Floats]], weights: dict[str, float]
) -> None:
    """No tooth comes through the skin outside the opening between the lips' red edges."""
    shape = posed(**weights)
    box = mouth_box(face, shape["skin"])
    xs, ys = np.arange(box[0], box[1], 0.5), np.arange(box[2], box[3], 0.5)
    skin = shape["skin"]
    inner = np.array(
        [skin[face.sites[f"lip_{edge}_inner{pair}"][1]] for edge in ("upper", "lower") for pair in INNER_PAIRS]
    )
    corners = [skin[face.sites[f"lip_corner_{side}"][1], 0] for side in ("left", "right")]
    for part in ("teeth_upper", "teeth_lower"):
        shown = in_front(face, shape, part, box, 0.5)
        rows, columns = np.nonzero(shown)
        assert ((xs[columns] < corners[0] + 1) & (xs[columns] > corners[1] - 1)).all()
        assert ((ys[rows] < inner[:, 1].max() + 4) & (ys[rows] > inner[:, 1].min() - 4)).all()


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(
    "gaze", [{}, {"eyeLookUp": 1.0}, {"eyeLookDown": 1.0}, {"eyeLookIn": 1.0}, {"eyeLookOut": 1.0}]
)
def test_a_full_blink_hides_the_eyeball(
    face: Face, posed: Callable[..., dict[str, Floats]], side: str, gaze: dict[str, float]
) -> None:
    weights = {f"eyeBlink{side}": 1.0} | {name + side: weight for name, weight in gaze.items() if name == "eyeLookDown"}
    turned = {name + side: weight for name, weight in gaze.items()}
    shape = posed(**(turned | weights))
    eye = next(eye for eye in face.eyes if eye.side == side)
    box = (eye.centre[0] - 17, eye.centre[0] + 17, -14.0, 12.0)
    shown = in_front(face, shape, eye.part, box, 0.4).sum() * 0.16
    assert shown <= (0.5 if not gaze else 6.0)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("weight", [0.0, 0.2, 0.4, 0.6, 0.8, 0.88])
def test_the_eyeball_is_seen_only_between_the_lids(
    face: Face, posed: Callable[..., dict[str, Floats]], side: str, weight: float
) -> None:
    shape = posed(**{f"eyeBlink{side}": weight})
    eye = next(eye for eye in face.eyes if eye.side == side)
    low = side.lower()
    box = (eye.centre[0] - 17, eye.centre[0] + 17, -14.0, 12.0)
    shown = in_front(face, shape, eye.part, box, 0.4)
    ys = np.arange(box[2], box[3], 0.4)
    rows = ys[np.nonzero(shown)[0]]
    upper, lower = (shape["skin"][face.sites[f"lid_{edge}_{low}"][1], 1] for edge in ("upper", "lower"))
    assert rows.size
    assert rows.max() < upper + 2.0
    assert rows.min() > lower - 2.0


@pytest.mark.parametrize("gaze", ["eyeLookUp", "eyeLookDown", "eyeLookIn", "eyeLookOut", "eyeWide", "eyeSquint"])
def test_the_eyeball_stays_inside_its_lids(face: Face, posed: Callable[..., dict[str, Floats]], gaze: str) -> None:
    shape = posed(**both(gaze))
    for eye in face.eyes:
        box = (eye.centre[0] - 20, eye.centre[0] + 20, -16.0, 16.0)
        shown = in_front(face, shape, eye.part, box, 0.5)
        columns, rows = (
            np.arange(box[0], box[1], 0.5)[np.nonzero(shown)[1]],
            np.arange(-16.0, 16.0, 0.5)[np.nonzero(shown)[0]],
        )
        low = eye.side.lower()
        inner, outer = (shape["skin"][face.sites[f"eye_{end}_{low}"][1], 0] for end in ("inner", "outer"))
        assert (columns > min(inner, outer) - 1.5).all()
        assert (columns < max(inner, outer) + 1.5).all()
        assert np.ptp(rows) < 15


def test_the_upper_lid_covers_the_top_of_the_iris(face: Face, posed: Callable[..., dict[str, Floats]]) -> None:
    skin = posed()["skin"]
    for side in ("left", "right"):
        upper, lower = (skin[face.sites[f"lid_{edge}_{side}"][1], 1] for edge in ("upper", "lower"))
        assert 2.0 < upper < 5.7  # the iris reaches 5.9 mm above the eye's centre
        assert 7.0 < upper - lower < 12.0


def test_tongue_tip_rises_behind_the_upper_teeth_and_comes_out(
    face: Face, posed: Callable[..., dict[str, Floats]]
) -> None:
    rest, up, back, out = (
        posed(jawOpen=0.2, **more)["tongue"]
        for more in ({}, {"tongueTipUp": 1.0}, {"tongueBackUp": 1.0}, {"tongueOut": 1.0})
    )
    tip = np.argmax(rest[:, 2])
    assert (up[:, 1] - rest[:, 1]).max() > 6
    assert up[tip, 1] - rest[tip, 1] > 3
    assert (back[:, 1] - rest[:, 1]).max() > 5
    assert back[tip, 1] - rest[tip, 1] < 3
    lip = posed(jawOpen=0.2)["skin"][face.sites["lip_lower_inner"][1], 2]
    assert out[:, 2].max() > lip + 3


@pytest.mark.parametrize(("viseme", "reach"), [("tongue_on_ridge", 4.0), ("lateral", 4.0), ("tongue_on_teeth", 0.0)])
def test_the_tongue_of_n_l_and_th_shows_between_the_teeth(
    posed: Callable[..., dict[str, Floats]], viseme: str, reach: float
) -> None:
    """Between the edges of the incisors it comes to their back, less ``reach`` mm; for /th/ through them."""
    from mien.core.channels import ALL
    from mien.motion.mouth.hand_made_mouth import HandMadeMouth

    shape = HandMadeMouth().visemes[viseme].shape
    parts = posed(**{name: float(weight) for name, weight in zip(ALL, shape, strict=True) if weight})
    upper, lower, tongue = (parts[name] for name in ("teeth_upper", "teeth_lower", "tongue"))
    upper, lower, tongue = (points[np.abs(points[:, 0]) < 5] for points in (upper, lower, tongue))
    edge, below = upper[:, 1].min(), lower[:, 1].max()
    back = upper[upper[:, 1] < edge + 3][:, 2].min()
    shown = tongue[(tongue[:, 1] < edge) & (tongue[:, 1] > below)]
    assert edge - below > 2.0
    assert shown[:, 2].max() > back - reach
    if viseme != "tongue_on_teeth":  # the tip stands behind the upper teeth, not in them
        assert tongue[tongue[:, 1] > edge + 0.5][:, 2].max() < back + 0.5


def test_head_weight_runs_from_the_trunk_to_the_face(face: Face) -> None:
    skin = face.part("skin")
    weight = skin.head_weight
    assert (weight[(skin.vertices[:, 1] > -60) & (skin.vertices[:, 2] > -60)] > 0.95).all()
    assert weight[face.sites["chin"][1]] > 0.99
    assert face.part("shirt").head_weight[face.part("shirt").vertices[:, 1] < -180].max() < 0.15
    ends = weight[skin.triangles]
    assert np.ptp(ends, axis=1).max() < 0.35


def test_sites_lie_where_their_names_say(face: Face) -> None:
    at = {name: face.part(part).vertices[vertex] for name, (part, vertex) in face.sites.items()}
    for name, place in at.items():
        if name.endswith("_left"):
            assert np.allclose(place * np.array([-1, 1, 1]), at[name.replace("_left", "_right")], atol=0.05)
    order = ("brow_middle_left", "lid_upper_left", "lid_lower_left", "nose_tip", "lip_upper_outer")
    heights = [at[name][1] for name in (*order, "lip_lower_inner", "lip_lower_outer", "chin")]
    assert heights == sorted(heights, reverse=True)

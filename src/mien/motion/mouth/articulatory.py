"""Articulatory parameters: principal components of the mouth taken in guided stages.

Frydrych et al. 2003, section 3.1.2, after Reveret & Essa 2001 (and Maeda 1990): "Application of PCA in stages lets to
select preferred motion for each principal component." Each stage looks at chosen coordinates only (its guide), takes
their first principal component in what earlier stages have left, and regresses all coordinates on it; what it explains
is taken out before the next stage. Jaw opening, mouth width and lip protrusion come first, then two components that
nothing guides: five in all. A parameter is scaled so that value 1 is one standard deviation in the recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.capture.cleaning.normalise import best_similarity
from mien.capture.layouts import load_layout
from mien.core.channels import HEAD, MOUTH
from mien.core.errors import InputError
from mien.corpus.take import Take
from mien.face.marker_regions import RegionDeformer, sites_of_layout
from mien.face.marker_sites import place_markers
from mien.face.model import Face
from mien.face.parameter_tree import Parameter, ParameterTree
from mien.face.posing import Poser
from mien.face.retargeting import Retargeter, basis_at
from mien.face.tree_of_face import translations_of, tree_of_face
from mien.face.tree_posing import TreePoser
from mien.motion.mouth.learned_mouth import NOT_BY_MARKERS
from mien.motion.mouth.mouth_space import MarkerSpace, mouth_space_of
from mien.motion.mouth.recorded_mouths import recorded_mouths

__all__ = [
    "STAGES",
    "ArticulatoryModel",
    "Stage",
    "articulatory_tree",
    "held_out_errors",
    "speaking_frames",
    "takes_apart",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stage:
    """One stage: a name, the landmarks whose coordinates guide it (none: all markers), and which axes of theirs."""

    name: str
    landmarks: tuple[int, ...] = ()
    axes: str = "xyz"


STAGES = (
    Stage("jaw_opening", (152, 175, 199, 200, 148, 377, 176, 400), "yz"),
    Stage("mouth_width", (61, 291, 78, 308), "x"),
    Stage("lip_protrusion", (0, 17, 13, 14, 37, 267, 84, 314, 82, 312, 87, 317), "z"),
    Stage("free_1"),
    Stage("free_2"),
)
"""Landmarks of MediaPipe's face mesh, by which layouts number their markers; those a layout lacks are passed over."""
_MARGIN = 0.1  # seconds of the mouth before and after speech
_HELD_OUT_EVERY = 10
_LEAST_REMAINDER = 0.05  # mm
_MOST_FRAMES = 400  # on which retargeting is compared


class ArticulatoryModel:
    """Guided principal components of mouth markers.

    Parameters
    ----------
    stages : sequence of Stage

    Attributes
    ----------
    markers_ : tuple of str
    layout_ : str
    mean_ : ndarray, shape (markers, 3)
    functionals_ : ndarray, shape (stages, markers * 3)
        A stage's score is its functional times what earlier stages left of a centred frame.
    loadings_ : ndarray, shape (stages, markers * 3)
        Millimetres per standard deviation.
    explained_ : ndarray, shape (stages,)
        Share of the variance that each stage takes out.
    """

    def __init__(self, stages: Sequence[Stage] = STAGES) -> None:
        self.stages = tuple(stages)

    def fit(self, positions: ArrayLike, markers: Sequence[str], layout: str) -> ArticulatoryModel:
        """Learn from frames, shape (frames, markers, 3), mm."""
        given = np.asarray(positions, dtype=np.float64)
        if given.ndim != 3 or given.shape[1:] != (len(markers), 3) or len(given) < 2:
            raise InputError(f"articulation: expected frames of {len(markers)} markers, got an array of {given.shape}")
        self.markers_, self.layout_, self.mean_ = tuple(markers), layout, given.mean(axis=0)
        left = given.reshape(len(given), -1) - self.mean_.ravel()
        total = float((left**2).sum())
        if not total > 0:
            raise InputError("articulation: the mouth does not move in these recordings")
        functionals, loadings, explained = [], [], []
        for stage in self.stages:
            guide = self._guide(stage)
            _, sizes, components = np.linalg.svd(left[:, guide].T @ left[:, guide])
            functional = np.zeros(left.shape[1])
            functional[guide] = components[0] * self._sign(stage, guide, components[0])
            spread = float(np.sqrt(sizes[0] / len(left)))
            functional /= max(spread, 1e-12)
            score = left @ functional
            loading = left.T @ score / max(float(score @ score), 1e-12)
            before = float((left**2).sum())
            left = left - np.outer(score, loading)
            explained.append((before - float((left**2).sum())) / total)
            functionals.append(functional)
            loadings.append(loading)
        self.functionals_, self.loadings_ = np.array(functionals), np.array(loadings)
        self.explained_ = np.array(explained)
        return self

    def scores(self, displacements: ArrayLike) -> Floats:
        """Values of the parameters for displacements from the mean, (frames, markers, 3), shape (frames, stages)."""
        left = np.asarray(displacements, dtype=np.float64).reshape(-1, self.mean_.size)
        found = np.empty((len(left), len(self.stages)))
        for number, (functional, loading) in enumerate(zip(self.functionals_, self.loadings_, strict=True)):
            found[:, number] = left @ functional
            left = left - np.outer(found[:, number], loading)
        return found

    def positions(self, scores: ArrayLike) -> Floats:
        """Marker positions at parameter values (frames, stages), shape (frames, markers, 3), mm."""
        moved = np.asarray(scores, dtype=np.float64) @ self.loadings_
        return np.asarray(self.mean_ + moved.reshape(-1, *self.mean_.shape))

    def summary(self) -> str:
        """Variance explained per stage, in words."""
        so_far = np.cumsum(self.explained_)
        lines = [
            f"{stage.name}: {100 * share:.1f} % of the variance, {100 * whole:.1f} % so far"
            for stage, share, whole in zip(self.stages, self.explained_, so_far, strict=True)
        ]
        return "\n".join(lines)

    def _sign(self, stage: Stage, guide: NDArray[np.int64], component: Floats) -> float:
        """Down for a jaw (yz), outward for a width (x), forward for a protrusion (z) count as positive."""
        axis = guide % 3
        if stage.axes == "yz":
            told = -component[axis == 1].sum()
        elif stage.axes == "x":
            told = float(component @ np.sign(self.mean_.ravel()[guide] - self.mean_[:, 0].mean()))
        elif stage.axes == "z":
            told = component.sum()
        else:
            told = component[np.abs(component).argmax()]
        return 1.0 if told >= 0 else -1.0

    def _guide(self, stage: Stage) -> NDArray[np.int64]:
        """Columns of the coordinates that guide a stage."""
        layout = load_layout(self.layout_)
        guiding = {layout.landmarks.get(number) for number in stage.landmarks}
        chosen = [k for k, name in enumerate(self.markers_) if not stage.landmarks or name in guiding]
        if not chosen:
            raise InputError(f"articulation: layout {self.layout_!r} has no marker that could guide {stage.name!r}")
        return np.array([3 * k + "xyz".index(axis) for k in chosen for axis in stage.axes], dtype=np.int64)


def takes_apart(takes: Sequence[Take]) -> tuple[list[Take], list[Take]]:
    """Takes to learn from, and every tenth, which is held out."""
    held = [take for number, take in enumerate(takes) if number % _HELD_OUT_EVERY == _HELD_OUT_EVERY - 1]
    kept = [take for number, take in enumerate(takes) if number % _HELD_OUT_EVERY != _HELD_OUT_EVERY - 1]
    return kept, held


def speaking_frames(takes: Sequence[Take]) -> tuple[Floats, tuple[str, ...], str]:
    """Mouth markers in the frames of speech, (frames, markers, 3), their names, and the layout."""
    if not takes:
        raise InputError("articulation: there are no takes to learn from")
    space = mouth_space_of(takes, MarkerSpace.kind)
    recorded = recorded_mouths(takes, _MARGIN, space)
    positions = space.motion_of(np.concatenate([mouth.rows for mouth in recorded]))
    return positions, space.names, takes[0].layout


def held_out_errors(model: ArticulatoryModel, positions: Floats, learned_from: Floats, face: Face) -> dict[str, float]:
    """RMS distance over markers and frames, mm: this model beside the mean, free components and the face's targets."""
    flat, trained = (p.reshape(len(p), -1) for p in (positions, learned_from))
    mean = model.mean_.ravel()
    _, _, components = np.linalg.svd((trained - mean).T @ (trained - mean))
    free = components[: len(model.stages)]
    sample = positions[:: max(1, len(positions) // _MOST_FRAMES)]
    to_face, sites = _laid_on(model, face)
    channels = [name for name in MOUTH if name not in NOT_BY_MARKERS]
    basis = basis_at(face, sites, channels)
    used = [name for name, column in zip(channels, basis, strict=True) if column.any()]
    closed = trained[np.argmin(np.linalg.norm(trained - np.quantile(trained, 0.5, axis=0), axis=1))]
    asked = (sample.reshape(len(sample), -1) - closed).reshape(sample.shape) @ to_face.T
    scale = float(np.cbrt(np.linalg.det(to_face)))
    by_targets = Retargeter(face, sites, used, steadiness=0.0).solve(asked).residual / scale

    def rms(missed: Floats) -> float:
        return float(np.sqrt((missed.reshape(len(missed), -1, 3) ** 2).sum(axis=2).mean()))

    return {
        "mean mouth": rms(flat - mean),
        f"guided components ({len(model.stages)})": rms(
            flat - model.positions(model.scores(positions - model.mean_)).reshape(len(flat), -1)
        ),
        f"free principal components ({len(model.stages)})": rms(flat - mean - (flat - mean) @ free.T @ free),
        f"blendshapes of face {face.name!r} ({len(used)})": float(np.sqrt((by_targets**2).mean())),
    }


def _laid_on(model: ArticulatoryModel, face: Face) -> tuple[Floats, tuple[tuple[str, int], ...]]:
    """Linear map (3, 3) from the speaker's millimetres to the face's, and the markers' sites."""
    layout = load_layout(model.layout_)
    placed = place_markers(face, layout, model.markers_)
    linear = best_similarity(model.mean_, placed.places, np.ones(len(placed.sites)), scale=True)[:3, :3]
    return np.asarray(linear, dtype=np.float64), placed.sites


def articulatory_tree(
    model: ArticulatoryModel, face: Face, directions: int = 3, remainders: bool = True
) -> ParameterTree:
    """A face's tree with the mouth moved by articulatory parameters instead of one leaf per channel.

    Parameters
    ----------
    model : ArticulatoryModel
    face : Face
        Any on which `mien.face.marker_sites` can put the markers.
    directions : int
        Translations per parameter: 3 show a component exactly, 1 is the paper's "one translation parameter per
        principal component".
    remainders : bool
        Whether what the parameters cannot say of a channel (they were learned from speech: no smile is in them) moves
        as a leaf of its own, so that every channel at 1 does what the face's target does. Without, channels move the
        parameters alone.

    Notes
    -----
    Components are spread over the skin by `mien.face.marker_regions`: markers of nose, eyes and upper cheeks hold
    still, the sides of the jaw follow the mouth's markers. Lower teeth and tongue ride the jaw's rotation. Each mouth
    channel drives the parameters by the scores of the displacement that it gives the markers, so that any performance
    moves the tree.
    """
    bare = replace(
        face,
        parts=tuple(
            part
            if part.name in ("teeth_lower", "tongue")
            else replace(part, targets={n: t for n, t in part.targets.items() if n not in MOUTH})
            for part in face.parts
        ),
    )
    still, own = set(load_layout(model.layout_).groups["upper"]), set(model.markers_)
    deformer = RegionDeformer(face, sites_of_layout(face, model.layout_).only(still | own))
    to_face, sites = _laid_on(model, face)
    channels = [n for n in MOUTH if any(n in part.targets for part in face.parts)]
    basis = basis_at(face, sites, channels) @ np.linalg.inv(to_face).T
    gains = model.scores(basis)
    row = {name: number for number, name in enumerate(deformer.sites.names)}
    leaves = []
    for number, stage in enumerate(model.stages):
        asked = np.zeros((len(row), 3))
        for name, vector in zip(model.markers_, model.loadings_[number].reshape(-1, 3) @ to_face.T, strict=True):
            if name in row:
                asked[row[name]] = vector
        field = {part: offsets.astype(np.float64) for part, offsets in deformer.offsets(asked).items()}
        drives = {c: float(g) for c, g in zip(channels, gains[:, number], strict=True) if abs(g) > 1e-4}
        drives[f"articulation_{stage.name}"] = 1.0
        leaves += translations_of(f"articulation_{stage.name}", field, drives, HEAD[-1], directions)
    opening = model.loadings_[0].reshape(-1, 3) @ to_face.T
    skeleton = tree_of_face(bare).parameters
    tree = ParameterTree((*(_following(parameter, model, opening, face) for parameter in skeleton), *leaves))
    if not remainders:
        return tree
    return ParameterTree((*tree.parameters, *_remainders(tree, face, channels, directions)))


def _remainders(tree: ParameterTree, face: Face, channels: Sequence[str], directions: int) -> list[Parameter]:
    """For every channel, leaves for the part of its target that the tree misses at 1."""
    plain = Poser(replace(face, tree=None), channels)
    driven = TreePoser(replace(face, tree=tree), channels)
    zero = np.zeros(len(channels))
    begin, leaves = driven.pose(zero), []
    for number, channel in enumerate(channels):
        row = np.eye(len(channels))[number]
        asked, got = plain.pose(row), driven.pose(row)
        field = {}
        for part, one, other, rest in zip(face.parts, asked.parts, got.parts, begin.parts, strict=True):
            missed = (one.vertices - part.vertices).astype(np.float64) - (other.vertices - rest.vertices)
            if np.abs(missed).max(initial=0.0) > _LEAST_REMAINDER:
                field[part.name] = missed
        if field:
            leaves += translations_of(f"rest_{channel}", field, {channel: 1.0}, HEAD[-1], directions)
    return leaves


def _following(parameter: Parameter, model: ArticulatoryModel, opening: Floats, face: Face) -> Parameter:
    """The jaw, driven by the first articulatory parameter too: it turns as far as lets the chin drop alike."""
    if parameter.name != "jaw" or "chin" not in face.sites:
        return parameter
    guide = sorted({int(k) // 3 for k in model._guide(model.stages[0])})
    fully = basis_at(face, [face.sites["chin"]], ["jawOpen"])[0, 0, 1]
    if not fully < 0:
        return parameter
    degrees = parameter.drives["jawOpen"] * float(opening[guide, 1].mean() / fully)
    return replace(parameter, drives={**parameter.drives, f"articulation_{model.stages[0].name}": degrees})

"""The ``.mien`` file: what was learned from one recorded person.

A zip archive of one ``performer.json`` and arrays as ``.npy`` (``numpy.load`` opens it as an ``.npz``)::

    performer.json    format, version, name, about (licence, attribution, corpus), mouth, settings, digests of
                      the takes it was learned from, counts of phone sequences, scalars of the models
    mouth/...         from version 4: in what the mouth was learned (`mien.motion.mouth.mouth_space`)
    speech/...        `SpeechMotion`: pose space, influence curves, networks, size of the motion, closures, edited key
                      shapes
    paper/...         `Coarticulation`: pose space, key shapes, curves of diphones and triphones, cost by degree
    graph/...         from version 2, if it was learned: the Anime Graph and the residuals of its nodes (`graph_file`),
                      read when they are first used
    expression/...    if it was learned: the expression space and its curves (`expression_file`)
    emotion_maps/...  from version 3, if they were learned: maps between emotions (`emotion_maps`)

Saving the same performer twice gives the same bytes; loading gives the same motion, bit for bit.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.border import reading
from mien.core.errors import InputError, unknown_name
from mien.core.files import replace_when_complete
from mien.core.limits import load_arrays, read_member
from mien.core.plain_text import parsed_json
from mien.motion.em_pca import EMPCA
from mien.motion.expression.expression_file import (
    RecordedExpressions,
    expression_arrays,
    expression_content,
    expressions_from,
)
from mien.motion.graph.combined_motion import CombinedMotion
from mien.motion.graph.graph_file import (
    PREFIX,
    RecordedSpeech,
    graph_arrays,
    graph_content,
    is_mapped,
    mapped_array,
    recorded_speech,
)
from mien.motion.graph.graph_motion import GraphMotion
from mien.motion.graph.recorded_residuals import RecordedResiduals
from mien.motion.maps.emotion_maps import EmotionMaps, emotion_map_arrays, emotion_map_content, emotion_maps_from
from mien.motion.mouth.coarticulation import Coarticulation, CoarticulationSettings
from mien.motion.mouth.correction import Correction, CorrectionSettings
from mien.motion.mouth.coverage import Coverage
from mien.motion.mouth.influence import InfluenceCurves, InfluenceSettings
from mien.motion.mouth.influence_curves import Curves
from mien.motion.mouth.lip_closure import LipClosure
from mien.motion.mouth.mouth_space import ChannelSpace, MarkerSpace, MouthSpace, space_from
from mien.motion.mouth.speech_model import SpeechModel
from mien.motion.mouth.speech_motion import SpeechMotion, SpeechMotionSettings
from mien.motion.mouth.spread import RecordedSpread

__all__ = ["FORMAT", "SPEECH_MODELS", "VERSION", "LearnedSpeech", "load_learned", "save_learned"]

FORMAT, VERSION = "mien-performer", 4
READABLE = (1, 2, 3, 4)
"""Version 1 has no graph, version 2 no maps between emotions; up to version 3 the mouth was learned in markers."""
SPEECH_MODELS = ("coarticulation", "graph", "both")
"""Names of the models of the speaking mouth: learned curves, recorded motion, curves corrected by what was recorded."""
_DATE = (1980, 1, 1, 0, 0, 0)
_DEFLATED = zipfile.ZIP_DEFLATED

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class LearnedSpeech:
    """What was learned of one person's speech.

    Attributes
    ----------
    name : str
    motion : SpeechMotion
        Learned curves: the speech model ``coarticulation``.
    coarticulation : Coarticulation
        The paper's curves, to look at and to compare with.
    fitting_cost : ndarray, shape (4, 6)
        Cost of the curves by λ (`curves.PENALTIES`) and degree 1 to 6 (Fig. 9).
    trained_on : tuple of str
        Identities (`mien.corpus.recordings.identity_of`) of the takes it was learned from.
    about : mapping of str to str
        Licence, attribution, corpus.
    recorded : RecordedSpeech or None
        Recorded motion: what the speech models ``graph`` and ``both`` need.
    speech_model : str
        The model that performs if none is asked for.
    expressions : RecordedExpressions or None
        Expressions learned from expressive takes with neutral twins.
    emotion_maps : EmotionMaps or None
        Maps between emotions, learned from sentences that were recorded in several.
    """

    name: str
    motion: SpeechMotion
    coarticulation: Coarticulation
    fitting_cost: NDArray[np.float64]
    trained_on: tuple[str, ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)
    recorded: RecordedSpeech | None = None
    speech_model: str = "coarticulation"
    expressions: RecordedExpressions | None = None
    emotion_maps: EmotionMaps | None = None

    @property
    def speech_models(self) -> tuple[str, ...]:
        """Models of the speaking mouth that this performer has."""
        if self.recorded is None:
            return SPEECH_MODELS[:1]
        return SPEECH_MODELS if self.recorded.has_residuals else SPEECH_MODELS[:2]

    def model(self, name: str | None = None) -> SpeechModel:
        """A model of the speaking mouth, by name; None takes the performer's own.

        Raises
        ------
        InputError
            If there is no model of that name, or the performer was learned without it.
        """
        name = name or self.speech_model
        if name not in SPEECH_MODELS:
            raise unknown_name("speech model", name, SPEECH_MODELS)
        if name not in self.speech_models or (self.recorded is None and name != "coarticulation"):
            has = ", ".join(self.speech_models)
            raise InputError(
                f"performer {self.name!r} has no speech model {name!r} (it has: {has}); "
                f"learn one with: mien learn CORPUS --speech-model {name}"
            )
        if self.recorded is None or name == "coarticulation":
            return self.motion
        if name == "graph" or self.recorded.residuals is None:
            return self.recorded.motion
        return CombinedMotion().restore(self.motion, self.recorded.residuals)


def save_learned(learned: LearnedSpeech, path: str | Path) -> None:
    """Write a performer; an older file of that name stays until the new one is complete.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    motion, paper = learned.motion, learned.coarticulation
    content = {
        "format": FORMAT,
        "version": VERSION,
        "name": learned.name,
        "about": dict(learned.about),
        "mouth": motion.mouth_.content(),
        "trained_on": learned.trained_on,
        "settings": {"speech": asdict(motion.settings), "paper": asdict(paper.settings)},
        "closure": {"apart": motion.closure_.apart_, "delay": motion.closure_.delay_},
        "coverage": {
            "least": motion.coverage_.least,
            "triphones": _joined(motion.coverage_.triphones_),
            "diphones": _joined(motion.coverage_.diphones_),
        },
        "curves": {" ".join(phones): [c.pairs, c.error] for phones, c in paper.curves_.items()},
        "class_curves": {" ".join(phones): [c.pairs, c.error] for phones, c in paper.class_curves_.items()},
        "keys": list(paper.keys_),
        "edited": list(motion.edits_),
        "speech_model": learned.speech_model,
    }
    arrays = {f"mouth/{name}": array for name, array in motion.mouth_.arrays().items()}
    arrays |= _speech_arrays(motion) | _paper_arrays(paper) | {"paper/fitting_cost": learned.fitting_cost}
    if learned.recorded is not None:
        content["graph"] = graph_content(learned.recorded)
        arrays |= graph_arrays(learned.recorded)
    if learned.expressions is not None:
        content["expression"] = expression_content(learned.expressions)
        arrays |= expression_arrays(learned.expressions)
    if learned.emotion_maps is not None:
        content["emotion_maps"] = emotion_map_content(learned.emotion_maps)
        arrays |= emotion_map_arrays(learned.emotion_maps)
    with replace_when_complete(path) as unfinished, zipfile.ZipFile(unfinished, "w") as archive:
        _write(archive, "performer.json", json.dumps(content, indent=1, ensure_ascii=False).encode())
        for name, array in arrays.items():
            entry = BytesIO()
            np.lib.format.write_array(entry, np.ascontiguousarray(array), allow_pickle=False)
            _write(archive, name + ".npy", entry.getvalue(), zipfile.ZIP_STORED if is_mapped(name) else _DEFLATED)


def _write(archive: zipfile.ZipFile, name: str, content: bytes, kind: int = _DEFLATED) -> None:
    entry = zipfile.ZipInfo(name, _DATE)  # a fixed date: the same performer, the same bytes
    entry.compress_type = kind
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, content)


def _joined(counts: Mapping[tuple[str, ...], int]) -> dict[str, int]:
    return {" ".join(phones): count for phones, count in counts.items()}


def _space_arrays(prefix: str, space: EMPCA) -> Arrays:
    return {
        f"{prefix}/mean": space.mean_,
        f"{prefix}/axes": space.axes_,
        f"{prefix}/weights": space.weights_,
        f"{prefix}/variances": np.append(space.variances_, [space.share_, space.steps_]),
    }


def _speech_arrays(motion: SpeechMotion) -> Arrays:
    arrays = _space_arrays("speech/space", motion.space_)
    arrays["speech/influence/weights"] = motion.curves_.weights_.astype(np.float32)  # exact: learned in this precision
    arrays["speech/influence/shapes"] = motion.curves_.shapes_.astype(np.float32)
    if motion.correction_ is not None:
        for number, layers in enumerate(motion.correction_.layers_):
            for depth, (weights, bias) in enumerate(layers):
                arrays[f"speech/correction/{number}/{depth}/weights"] = weights.astype(np.float32)
                arrays[f"speech/correction/{number}/{depth}/bias"] = bias.astype(np.float32)
    if motion.spread_ is not None:
        spread = motion.spread_
        arrays["speech/spread"] = np.stack([spread.centre_, spread.gain_, spread.sharpness_])
    arrays["speech/closing"] = motion.closure_.closing_
    if motion.delays_.any():
        arrays["speech/delays"] = motion.delays_
    for phone, offsets in motion.edits_.items():
        arrays[f"speech/edits/{phone}"] = offsets
    return arrays


def _paper_arrays(paper: Coarticulation) -> Arrays:
    arrays = _space_arrays("paper/space", paper.space_)
    arrays["paper/keys"] = np.array(list(paper.keys_.values()))
    for name, curves in (("curves", paper.curves_), ("class_curves", paper.class_curves_)):
        columns = [c.coefficients for c in curves.values()]
        arrays[f"paper/{name}"] = (
            np.concatenate(columns, axis=1) if columns else np.zeros((paper.settings.degree + 1, 0))
        )
    return arrays


def load_learned(path: str | Path) -> LearnedSpeech:
    """Read a performer.

    Raises
    ------
    InputError
        If the file is missing, damaged, of another kind or of a newer version.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file; a performer is made by: mien learn CORPUS -o NAME.mien")
    with reading(path, "a performer"):
        with zipfile.ZipFile(path) as archive:
            written = read_member(archive, "performer.json", path)
        content = parsed_json(written)
        if content.get("format") != FORMAT or content.get("version") not in READABLE:
            found = f"{str(content.get('format'))[:40]} {str(content.get('version'))[:40]}"
            raise InputError(f"{path}: expected {FORMAT} {VERSION}, found {found}; learn it again or update mien")
        arrays: Arrays = load_arrays(path, only=lambda name: not name.startswith(PREFIX) and name != "performer.json")
        motion = _speech_from(content, arrays)
        paper = _paper_from(content, arrays, motion.mouth_)
        return LearnedSpeech(
            content["name"],
            motion,
            paper,
            arrays["paper/fitting_cost"],
            tuple(content["trained_on"]),
            content["about"],
            _recorded_from(path, written, content, motion) if "graph" in content else None,
            content.get("speech_model", "coarticulation"),
            expressions_from(content["expression"], arrays) if "expression" in content else None,
            emotion_maps_from(content["emotion_maps"], arrays) if "emotion_maps" in content else None,
        )


def _recorded_from(path: Path, written: bytes, content: Mapping[str, Any], motion: SpeechMotion) -> RecordedSpeech:
    """The graph of a file, read when it is first used."""

    def read() -> tuple[GraphMotion, RecordedResiduals | None]:
        with reading(path, "the graph of a performer"), zipfile.ZipFile(path) as archive:
            if read_member(archive, "performer.json", path) != written:
                raise InputError(f"{path}: was changed after it was loaded; load it again")
            graph = content["graph"]
            return recorded_speech(
                graph, lambda name: mapped_array(path, archive, name), motion.mouth_, motion.closure_
            )

    graph = content["graph"]
    return RecordedSpeech("residual_weights" in graph, tuple(graph["emotion_names"]), read)


def _space_from(prefix: str, components: int, arrays: Arrays) -> EMPCA:
    space = EMPCA(components)
    space.mean_, space.axes_ = arrays[f"{prefix}/mean"], arrays[f"{prefix}/axes"]
    space.weights_ = arrays.get(f"{prefix}/weights", np.ones(len(space.mean_)))  # absent: all dimensions count alike
    numbers = arrays[f"{prefix}/variances"]
    space.variances_, space.share_, space.steps_ = numbers[:-2], float(numbers[-2]), int(numbers[-1])
    return space


def _speech_from(content: Mapping[str, Any], arrays: Arrays) -> SpeechMotion:
    given = {key: value for key, value in content["settings"]["speech"].items() if key != "lip_emphasis"}
    given.setdefault("as_recorded", False)  # up to version 3
    influence = InfluenceSettings(**given.pop("influence"))
    correction = dict(given.pop("correction"))
    correction["hidden"] = tuple(correction["hidden"])
    settings = SpeechMotionSettings(**given, influence=influence, correction=CorrectionSettings(**correction))
    motion = SpeechMotion(settings)
    motion.mouth_ = _mouth_from(content, arrays)
    motion.space_ = _space_from("speech/space", settings.components, arrays)
    motion.curves_ = InfluenceCurves(influence)
    motion.curves_.weights_ = arrays["speech/influence/weights"].astype(np.float64)
    motion.curves_.shapes_ = arrays["speech/influence/shapes"].astype(np.float64)
    motion.correction_ = _correction_from(settings, arrays)
    motion.spread_ = RecordedSpread().restore(*arrays["speech/spread"]) if "speech/spread" in arrays else None
    motion.closure_ = LipClosure(motion.mouth_)
    motion.closure_.closing_ = arrays["speech/closing"].ravel()
    motion.closure_.apart_, motion.closure_.delay_ = content["closure"]["apart"], content["closure"]["delay"]
    coverage = content["coverage"]
    motion.coverage_ = Coverage(coverage["least"]).restore(_split(coverage["triphones"]), _split(coverage["diphones"]))
    motion.delays_ = arrays.get("speech/delays", np.zeros(len(motion.space_.axes_)))
    motion.edits_ = {phone: arrays[f"speech/edits/{phone}"] for phone in content["edited"]}
    return motion


def _mouth_from(content: Mapping[str, Any], arrays: Arrays) -> MarkerSpace | ChannelSpace:
    if "mouth" not in content:  # up to version 3
        return MarkerSpace(content["layout"], content["markers"])
    return space_from(content["mouth"], {name.removeprefix("mouth/"): array for name, array in arrays.items()})


def _correction_from(settings: SpeechMotionSettings, arrays: Arrays) -> Correction | None:
    if settings.correction_share <= 0:
        return None
    correction = Correction(settings.correction)
    correction.layers_ = [
        [
            (
                arrays[f"speech/correction/{number}/{depth}/weights"].astype(np.float64),
                arrays[f"speech/correction/{number}/{depth}/bias"].astype(np.float64),
            )
            for depth in range(len(settings.correction.hidden) + 1)
        ]
        for number in range(settings.correction.networks)
    ]
    return correction


def _split(counts: Mapping[str, int]) -> dict[tuple[str, ...], int]:
    return {tuple(phones.split(" ")): count for phones, count in counts.items()}


def _paper_from(content: Mapping[str, Any], arrays: Arrays, mouth: MouthSpace) -> Coarticulation:
    paper = Coarticulation(CoarticulationSettings(**content["settings"]["paper"]))
    paper.mouth_ = mouth
    paper.space_ = _space_from("paper/space", paper.settings.components, arrays)
    paper.keys_ = dict(zip(content["keys"], arrays["paper/keys"], strict=True))
    paper.curves_ = _curves_from(content["curves"], arrays["paper/curves"])
    paper.class_curves_ = _curves_from(content["class_curves"], arrays["paper/class_curves"])
    return paper


def _curves_from(listed: Mapping[str, Any], columns: NDArray[Any]) -> dict[tuple[str, ...], Curves]:
    curves: dict[tuple[str, ...], Curves] = {}
    start = 0
    for phones, (pairs, error) in listed.items():
        said = tuple(phones.split(" "))
        curves[said] = Curves(np.ascontiguousarray(columns[:, start : start + len(said)]), pairs, error)
        start += len(said)
    return curves

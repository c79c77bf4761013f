"""mien: speech or text in, an expressive 3D talking face out.

>>> import mien
>>> [name for name in dir(mien) if name[0].islower()]  # doctest: +NORMALIZE_WHITESPACE
['align', 'animate', 'doctor', 'evaluate', 'express', 'faces', 'import_corpus', 'learn', 'load', 'recolor', 'save',
 'say', 'score', 'stimuli']

The names are loaded when first used, so that ``import mien`` stays quick, and the command's first lines are reached
before anybody can stop it: nothing is imported here, not even ``typing``.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from mien.animation.animation import Animation
    from mien.api.calls import align, animate, express, save, say
    from mien.api.corpus_calls import faces, import_corpus, learn, load, stimuli
    from mien.api.diagnosis import doctor
    from mien.api.evaluation_calls import evaluate
    from mien.api.recoloring import recolor
    from mien.core.audio import Audio
    from mien.core.errors import InputError, MienError
    from mien.core.utterance import Utterance
    from mien.corpus.recordings import Corpus
    from mien.corpus.take import Take
    from mien.face.model import Face
    from mien.metrics.scoring import score
    from mien.motion.performer import Performer

__all__ = [
    "Animation",
    "Audio",
    "Corpus",
    "Face",
    "InputError",
    "MienError",
    "Performer",
    "Take",
    "Utterance",
    "align",
    "animate",
    "doctor",
    "evaluate",
    "express",
    "faces",
    "import_corpus",
    "learn",
    "load",
    "recolor",
    "save",
    "say",
    "score",
    "stimuli",
]

_HOMES = {
    "Animation": "mien.animation.animation",
    "Audio": "mien.core.audio",
    "Corpus": "mien.corpus.recordings",
    "Face": "mien.face.model",
    "InputError": "mien.core.errors",
    "MienError": "mien.core.errors",
    "Performer": "mien.motion.performer",
    "Take": "mien.corpus.take",
    "Utterance": "mien.core.utterance",
    "align": "mien.api.calls",
    "animate": "mien.api.calls",
    "doctor": "mien.api.diagnosis",
    "evaluate": "mien.api.evaluation_calls",
    "express": "mien.api.calls",
    "faces": "mien.api.corpus_calls",
    "import_corpus": "mien.api.corpus_calls",
    "learn": "mien.api.corpus_calls",
    "load": "mien.api.corpus_calls",
    "recolor": "mien.api.recoloring",
    "save": "mien.api.calls",
    "say": "mien.api.calls",
    "score": "mien.metrics.scoring",
    "stimuli": "mien.api.corpus_calls",
}


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("mien")
    if name not in _HOMES:
        raise AttributeError(f"module 'mien' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)

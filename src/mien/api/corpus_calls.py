"""The calls around recordings and files: `load`, `import_corpus`, `learn`, `stimuli`, `faces`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from mien.animation.animation import Animation
from mien.core.errors import InputError, Note, unknown_name
from mien.core.files import check_writable
from mien.corpus import importing
from mien.corpus.recordings import Corpus
from mien.face.library import known_faces

if TYPE_CHECKING:
    from mien.api.stimuli import StimuliReport
    from mien.motion.performer import Performer
    from mien.motion.performer_file import LearnedSpeech

__all__ = ["faces", "import_corpus", "learn", "load", "stimuli"]

_P = ParamSpec("_P")
_R = TypeVar("_R")

_LOADED = (".json", ".csv", ".mien")


def _finding_markers(call: Callable[_P, _R]) -> Callable[_P, _R]:
    """The call, with what finds markers in meshes: the rooms of corpora and of fitting do not know each other."""

    @wraps(call)
    def finding(*args: _P.args, **options: _P.kwargs) -> _R:
        from mien.fit.mesh_markers import vertices_for

        return call(*args, **{"vertices_for": vertices_for, **options})  # type: ignore[arg-type]

    return finding


import_corpus = _finding_markers(importing.import_corpus)


def load(path: str | Path) -> Animation | Performer | Corpus:
    """Read what mien keeps: an animation, a performer or a corpus.

    Parameters
    ----------
    path : str or Path
        A native animation (``.json``), a Live Link Face recording (``.csv``), a performer (``.mien``), or the folder of
        a corpus.

    Raises
    ------
    InputError
        If it is none of these, missing or damaged.

    Examples
    --------
    >>> load("line.mp3")
    Traceback (most recent call last):
        ...
    mien.core.errors.InputError: line.mp3: no such file or folder
    """
    path = Path(path)
    if path.is_dir():
        return Corpus(path)
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    suffix = path.suffix.lower()
    if suffix not in _LOADED:
        raise unknown_name("kind of file", suffix, _LOADED)
    if suffix == ".mien":
        from mien.motion.performers import load_performer

        return load_performer(path)
    from mien.api.calls import read_motion

    return read_motion(path)


def learn(
    corpus: Corpus | str | Path,
    output: str | Path | None = None,
    *,
    name: str | None = None,
    speech_model: str = "both",
    start: str | Path | None = "default",
    exclude_words: Collection[str] = (),
    exclude_names: Collection[str] = (),
    speakers: str = "one",
    tell: Callable[[Note], None] = lambda note: None,
    progress: Callable[[int, int, str], None] | None = None,
    workers: int | None = 0,
    cluster: str | None = None,
) -> LearnedSpeech:
    """Learn a performer from a corpus.

    Parameters
    ----------
    corpus : Corpus, str or Path
        A corpus, or its folder (`import_corpus`).
    output : str, Path or None
        The ``.mien`` file to write; None writes none.
    name : str or None
        Of the performer; None takes that of the file.
    speech_model : {"coarticulation", "graph", "both"}
        What it speaks with by default.
    start : str, Path or None
        The performer whose mouth is started from, so that a few takes are enough; None starts from nothing.
    exclude_words, exclude_names : collection of str
        Takes in which one of these words is said, or that have one of these names, are held out.
    speakers : str
        ``"one"``: there must be one; ``"mixed"``: several may share one mouth; else the name of the one to learn from.
    tell : callable
        Takes what is said of the corpus before anything is learned: minutes, phones that are missing, takes left out.
    progress : callable (done, total, what) or None
    workers : int or None
        Processes that learn; 0: this one, None: one per core. The result is the same.
    cluster : str or None
        Address of a Dask scheduler, on whose workers is learned.

    Returns
    -------
    LearnedSpeech
        What was learned; `mien.save` and ``performer=`` take the file.

    Raises
    ------
    InputError
        If the corpus holds too little to learn from.
    OutputError
        If the file cannot be written.
    """
    from mien.motion.learning import LearningSettings, learn_corpus
    from mien.motion.performer_file import save_learned
    from mien.motion.performers import start_named

    path = check_writable(output) if output is not None else None
    if path is not None and path.suffix.lower() != ".mien":
        raise InputError(f"a performer is kept in a .mien file, not in {path}: give it a name that ends in .mien")
    learned = learn_corpus(
        corpus if isinstance(corpus, Corpus) else Corpus(corpus),
        LearningSettings(speech_model=speech_model),
        prior=None if start is None else start_named(str(start)),
        progress=progress,
        name=name or (path.stem if path is not None else "learned"),
        exclude_words=exclude_words,
        exclude_names=exclude_names,
        speakers=speakers,
        tell=tell,
        workers=workers,
        cluster=cluster,
    )
    if path is not None:
        save_learned(learned, path)
    return learned


def stimuli(
    design: str | Path,
    folder: str | Path,
    *,
    lists: int = 0,
    formats: Sequence[str] = (),
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> StimuliReport:
    """Make the stimuli of a factorial design (``docs/stimuli.md``).

    Parameters
    ----------
    design : str or Path
        A table with one row for each stimulus; levels ``a|b`` are crossed.
    folder : str or Path
        Filled with videos and a log of every frame; a run that was stopped goes on.
    lists : int
        How many counterbalanced lists to write besides.
    formats : sequence of str
        Suffixes of what is written besides each video, such as ``".glb"``.
    workers, cluster
        Processes on this machine, or the address of a Dask scheduler.

    Raises
    ------
    InputError
        If the table cannot be read; its row and column are named.
    """
    from mien.api.stimuli import make_stimuli, read_design

    return make_stimuli(
        read_design(design),
        folder,
        lists=lists,
        formats=formats,
        workers=workers,
        cluster=cluster,
        progress=progress,
    )


def faces() -> tuple[str, ...]:
    """Names of the faces that come with mien.

    Examples
    --------
    >>> "default" in faces()
    True
    """
    return known_faces()

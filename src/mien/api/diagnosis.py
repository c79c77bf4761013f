"""`doctor`: what is installed, what is missing, and what that costs."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

__all__ = ["Finding", "Report", "doctor"]


@dataclass(frozen=True)
class Finding:
    """One line of the report.

    Attributes
    ----------
    part : str
        Section and name of what was looked at.
    state : str
        ``"ok"``, ``"missing"`` (the main job suffers) or ``"optional"`` (absent, and that is fine).
    detail : str
        Version and licence, or what the absence costs and the command that ends it.
    """

    part: str
    state: str
    detail: str


@dataclass(frozen=True)
class Report:
    """What `doctor` found; ``str(report)`` is the table that the command prints."""

    findings: tuple[Finding, ...]

    @property
    def healthy(self) -> bool:
        """Whether the main job can be done: nothing that it needs is missing."""
        return all(finding.state != "missing" for finding in self.findings)

    def __str__(self) -> str:
        width = max(len(finding.part) for finding in self.findings)
        lines = [f"{f.state:8}  {f.part:{width}}  {f.detail}" for f in self.findings]
        verdict = "ready" if self.healthy else "not ready: see the lines marked 'missing'"
        return "\n".join([*lines, f"mien is {verdict}."])


def doctor() -> Report:
    """Look at this installation.

    Examples
    --------
    >>> doctor().findings[0].part
    'mien'
    """
    return Report((*_core(), *_voices(), *_listening(), *_faces(), *_performers(), *_recording(), *_pictures()))


def _core() -> list[Finding]:
    found = [
        Finding("mien", "ok", f"{version('mien')} (Apache-2.0), Python {platform.python_version()} on {sys.platform}")
    ]
    for package, cost in (
        ("numpy", "nothing works"),
        ("scipy", "nothing works"),
        ("numba", "no face can be posed or drawn"),
        ("soundfile", "no sound can be read"),
        ("soxr", "no sound can be resampled"),
    ):
        found.append(_package(package, cost))
    return [*found, *_system(), _kernels(), *_own_tables()]


def _system() -> list[Finding]:
    """What is known about systems that mien is not tested on (``docs/platforms.md``)."""
    if sys.platform.startswith("linux"):
        return []
    untried = "mien is tested on Linux; what differs here is in docs/platforms.md"
    if sys.platform == "win32":
        untried += ": no Festival voices, phones without a text by pocketsphinx alone, no locks between programs"
    return [Finding("system", "optional", untried)]


def _kernels() -> Finding:
    from mien.core.compiled import cache_note

    return Finding("kernels", "ok", cache_note())


def _own_tables() -> list[Finding]:
    from mien.core.assets import own_folder, own_tables

    tables = own_tables()
    return [Finding("tables of your own", "ok", f"in {own_folder()}: {', '.join(tables)}")] if tables else []


def _package(name: str, cost: str) -> Finding:
    try:
        return Finding(name, "ok", version(name))
    except PackageNotFoundError:
        return Finding(name, "missing", f"not installed: {cost}; pip install {name}")


def _voices() -> list[Finding]:
    from mien.core.errors import MissingPartError
    from mien.speech.voices import catalogue, get_voice

    try:
        chosen = get_voice(None).name
    except MissingPartError as problem:
        found = [Finding("voice", "missing", f"mien say cannot speak: {problem}")]
        chosen = ""
    else:
        found = [Finding("voice", "ok", f"{chosen} speaks unless --voice says otherwise")]
    for voice in catalogue():
        availability = voice.availability()
        state = "ok" if availability.installed else "optional"
        detail = f"{voice.engine}, {voice.language}; {voice.licence}; {voice.lineage}; {availability.hint}"
        found.append(Finding(f"voice {voice.name}", state, detail))
    return found


def _listening() -> list[Finding]:
    found = [_package("pocketsphinx", "no speech can be aligned with its text")]
    if find_spec("hama") is not None:
        found.append(Finding("hama", "ok", f"{version('hama')}: recognises phones where no text is given"))
    else:
        cost = "without a text, pocketsphinx guesses words instead: less exact; pip install hama"
        found.append(Finding("hama", "optional", cost))
    return found


def _faces() -> list[Finding]:
    from mien.face.library import load_face

    face = load_face("default")
    vertices = sum(len(part.vertices) for part in face.parts)
    return [Finding("face default", "ok", f"{vertices} vertices; {face.licence}")]


def _performers() -> list[Finding]:
    from mien.motion.performers import load_learned_performer

    learned = load_learned_performer("default")
    origin = f"mouth learned from {len(learned.trained_on)} takes; {learned.about.get('licence', '')}: see NOTICE"
    return [Finding("performer default", "ok", f"{origin}; expression and idle motion hand-made")]


def _recording() -> list[Finding]:
    from mien.capture.tracker import tracker_python
    from mien.core.errors import MissingPartError

    try:
        found = [Finding("face tracker", "ok", str(tracker_python()))]
    except MissingPartError:
        found = [Finding("face tracker", "optional", "no corpus from video without it; mien tracker install")]
    if find_spec("distributed") is None:
        found.append(Finding("dask", "optional", "no work on a cluster without it; pip install 'mien[dask]'"))
    else:
        found.append(Finding("dask", "ok", f"{version('distributed')}: --cluster of corpus import, stimuli and batch"))
    for name, package, tag in (("words of Chinese", "rjieba", "zh"), ("words of Japanese", "janome", "ja")):
        if find_spec(package) is None:
            told = f"text needs blanks between words without it; pip install 'mien[{tag}]'"
            found.append(Finding(name, "optional", told))
        else:
            found.append(Finding(name, "ok", f"{package} {version(package)}"))
    found.append(_microphone())
    return found


def _microphone() -> Finding:
    try:
        import sounddevice
    except ImportError:
        return Finding("microphone", "optional", "mien live takes files and pipes only; pip install 'mien[live]'")
    except OSError as problem:  # the package is there, PortAudio is not
        return Finding("microphone", "optional", f"{problem}; install PortAudio (Debian: libportaudio2)")
    return Finding("microphone", "ok", f"sounddevice {sounddevice.__version__}: mien live")


def _bundle(package: str) -> Path:
    """The folder of the libraries that a wheel brings; the package's own where it was built on this machine."""
    beside = Path(package).parent.with_name("av.libs")
    return beside if beside.is_dir() else Path(package).parent


def _pictures() -> list[Finding]:
    import av

    found = []
    for codec, use in (("libx264", "H.264 picture"), ("aac", "AAC sound")):
        present = codec in av.codecs_available
        licence = f"; GPL-2.0-or-later, in {_bundle(av.__file__)}" if codec == "libx264" else ""
        lacking = f"no {use} in PyAV: no .mp4; pip install --upgrade av"
        detail = f"PyAV {av.__version__}, {use}{licence}" if present else lacking
        found.append(Finding(f"codec {codec}", "ok" if present else "missing", detail))
    found.append(Finding("renderer", "ok", "own rasteriser on the processor: needs no GPU and no system package"))
    found += [_graphics_card(), _usd(), _fbx()]
    return found


def _graphics_card() -> Finding:
    from mien.core.errors import MissingPartError
    from mien.face.render.graphics_card import graphics_card

    try:
        return Finding("graphics card", "ok", f"{graphics_card().name}: --painter gpu")
    except MissingPartError as problem:
        return Finding("graphics card", "optional", str(problem))


def _fbx() -> Finding:
    from mien.core.errors import MissingPartError
    from mien.face.foreign.blender_bridge import blender_command

    try:
        return Finding("fbx", "ok", f"by way of Blender: {blender_command()[0]}")
    except MissingPartError as problem:
        return Finding("fbx", "optional", str(problem))


def _usd() -> Finding:
    if find_spec("pxr") is None:
        return Finding("usd", "optional", "no .usdz, .usdc, .usda without it: pip install 'mien[usd]'")
    return Finding("usd", "ok", f"usd-core {version('usd-core')}: writes .usdz, .usdc, .usda")

"""Projects: takes with their steps, sounds and faces, and the state of the page, as one zip file."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterable
from typing import Any

from mien.core.border import reading
from mien.core.errors import InputError
from mien.serve.studio.bodies import parsed
from mien.serve.studio.journal import Journal, Record, record_of
from mien.serve.studio.requests import FieldError
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_faces import FaceShelf

__all__ = ["read_project", "written_project"]

FORMAT, VERSION = "mien-project", 1
_MOST_TAKES = 500


def written_project(journal: Journal, faces: FaceShelf, names: Iterable[str]) -> bytes:
    """Takes as one file; raises `mien.serve.studio.lru_store.Missing`."""
    records = {name: journal.get(name) for name in names}
    sounds = {step.sound for record in records.values() for step in record.steps if step.sound is not None}
    told = {
        "format": FORMAT,
        "version": VERSION,
        "takes": {name: record.plain() for name, record in records.items()},
        "page": journal.page(),
    }
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("project.json", json.dumps(told))
        for digest in sorted(sounds):
            path = journal.folder / "sounds" / f"{digest}.npz"
            if path.is_file():
                archive.write(path, f"sounds/{digest}.npz")
        for face in faces.listed():
            if face["own"]:
                archive.writestr(f"faces/{face['face']}.json", json.dumps({"name": face["name"]}))
                archive.writestr(f"faces/{face['face']}.glb", faces.glb(face["face"]))
    return content.getvalue()


def read_project(content: bytes, journal: Journal, faces: FaceShelf, limits: Limits) -> dict[str, Any]:
    """Add what a project holds to a studio; gives ``{"takes": {old id: id}, "faces": {old id: id}, "page": state}``.

    Raises
    ------
    InputError
        If it is none, or is too large.
    """
    try:
        with reading("the file", "a project of mien's studio"), zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _read(archive, journal, faces, limits)
    except InputError as problem:
        raise problem if isinstance(problem, FieldError) else FieldError("project", str(problem)) from problem


def _read(archive: zipfile.ZipFile, journal: Journal, faces: FaceShelf, limits: Limits) -> dict[str, Any]:
    if sum(item.file_size for item in archive.infolist()) > limits.kept_bytes:
        raise FieldError(
            "project", f"the project holds more than the {limits.kept_bytes:,} bytes that the studio takes"
        )
    if "project.json" not in archive.namelist():
        raise FieldError("project", "this file is not a project of mien's studio: it holds no project.json")
    told = parsed(archive.read("project.json"))
    if told.get("format") != FORMAT or told.get("version") != VERSION or not isinstance(told.get("takes"), dict):
        raise FieldError("project", f"expected {FORMAT}, version {VERSION}")
    if len(told["takes"]) > _MOST_TAKES:
        raise FieldError("project", f"a project holds at most {_MOST_TAKES} takes")
    records: dict[str, Record] = {}
    for name, plain in told["takes"].items():
        if not isinstance(plain, dict):
            raise FieldError("project", "a take is an object")
        records[name] = record_of(plain, limits)
    for item in archive.namelist():
        if re.fullmatch(r"sounds/[0-9a-f]{64}\.npz", item):
            journal.add_sound(archive.read(item), limits)
    opened = {}
    for item in archive.namelist():
        face = re.fullmatch(r"faces/([A-Za-z0-9_-]{8,32})\.glb", item)
        if face is not None:
            about = f"faces/{face[1]}.json"
            name = str(parsed(archive.read(about)).get("name", "")) if about in archive.namelist() else ""
            opened[face[1]] = faces.add(archive.read(item), name)[0]
    page = told.get("page")
    takes = {name: journal.add(record, name) for name, record in records.items()}
    return {"takes": takes, "faces": opened, "page": page if isinstance(page, dict) else {}}

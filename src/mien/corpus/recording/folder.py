"""The folder of a session: recordings by name, and ``table.csv`` that says what each is. Plain files, ready to import.

::

    SESSION/
      table.csv                     name,text,emotion,sentence,speaker
      anna-happy-english-001.mp4    pictures; their sound inside, or in
      anna-happy-english-001.wav    the sound

A take is there when its line is in the table; its files are written before its line.
"""

from __future__ import annotations

import csv
import errno
import io
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from mien.core.errors import InputError, OutputError
from mien.core.files import replace_when_complete
from mien.corpus.transcripts import read_table

__all__ = ["COLUMNS", "SessionFolder", "plain_name", "writing"]

COLUMNS = ("name", "text", "emotion", "sentence", "speaker")


def plain_name(what: str, value: str) -> str:
    """A name that may stand in the names of files.

    Raises
    ------
    InputError
        If it is empty or has anything but letters, digits and ``_``.

    Examples
    --------
    >>> plain_name("speaker", "anna")
    'anna'
    """
    if not value or not all(char.isalnum() or char == "_" for char in value):
        raise InputError(f"the {what} goes into names of files: letters, digits and '_' only, not {value!r}")
    return value


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn a failure to write at ``path`` into one line.

    Raises
    ------
    OutputError
    """
    try:
        yield
    except OSError as problem:
        if problem.errno == errno.ENOSPC:
            raise OutputError(f"cannot write {path}: the disk is full; free some space and run again") from problem
        raise OutputError(f"cannot write {path}: {problem.strerror or problem}") from problem


class SessionFolder:
    """A session on disk; made if it is not there, gone on with if it is.

    Parameters
    ----------
    folder : str or Path

    Raises
    ------
    InputError
        If its table cannot be read.
    OutputError
        If it cannot be made or written to.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        self.table = self.folder / "table.csv"
        with writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.folder):
                pass
        self.rows: dict[str, dict[str, str]] = read_table(self.table)[0] if self.table.exists() else {}

    def files_of(self, name: str) -> list[Path]:
        """Files of a take, sorted."""
        return sorted(path for path in self.folder.iterdir() if path.stem == name and path.is_file())

    def has(self, name: str, text: str) -> bool:
        """Whether a take of this sentence is there.

        Raises
        ------
        InputError
            If one is there that says something else: the script was changed since.
        """
        row = self.rows.get(name)
        if row is None or not self.files_of(name):
            return False
        if row.get("text") != text:
            raise InputError(
                f"{self.table}: {name} says {row.get('text', '')!r}, the script now says {text!r}: "
                "give another folder, or the script as it was"
            )
        return True

    @contextmanager
    def scratch(self) -> Iterator[Path]:
        """A folder on the same disk for a take that is not kept yet; gone afterwards."""
        with writing(self.folder):
            place = Path(tempfile.mkdtemp(prefix=".taking-", dir=self.folder))
        try:
            yield place
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def keep(self, name: str, facts: Mapping[str, str], files: Sequence[Path]) -> None:
        """Move the files of a take in, under its name, in place of what was there, and write its line.

        Parameters
        ----------
        name : str
        facts : mapping of str to str
            By `COLUMNS`, without the name.
        files : sequence of Path
            From `scratch`; told apart by their suffixes.
        """
        with writing(self.folder):
            for path in files:
                path.replace(self.folder / f"{name}{path.suffix.lower()}")
            suffixes = {path.suffix.lower() for path in files}
            for stale in self.files_of(name):
                if stale.suffix not in suffixes:
                    stale.unlink()
        self.rows[name] = dict(facts)
        self._write_table()

    def _write_table(self) -> None:
        text = io.StringIO()
        writer = csv.DictWriter(text, COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        for name in sorted(self.rows):
            writer.writerow({"name": name, **self.rows[name]})
        with replace_when_complete(self.table) as unfinished:
            unfinished.write_text(text.getvalue(), encoding="utf-8", newline="")

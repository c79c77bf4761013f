"""Cutting a stream of lines into messages.

A writer puts one message on one line. A reader also takes an element over several lines, and a command whose tag was
left open, as the paper prints it (``<HeadNod at="1000" amplitude="60"`` / ``count="2">``): it is closed.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field

from mien.core.errors import InputError
from mien.text.tags import ROOTS

__all__ = ["MOST_CHARACTERS", "Message", "Messages"]

_CUT = re.compile(r"</?([A-Za-z_][\w.:-]*)[^<>]*$")
_OPEN_LINES = 20
"""Lines over which a command may be left open."""
_PROLOG = {"<?": "?>", "<!--": "-->", "<!DOCTYPE": ">"}
MOST_CHARACTERS = 256_000_000
"""Longest message: over an hour of sound."""
_NAME = re.compile(r"\s*<([A-Za-z_][\w.:-]*)")
_LONE_OPEN = re.compile(r"""\s*<([A-Za-z_][\w.:-]*)(\s+[\w.:-]+\s*=\s*("[^"]*"|'[^']*'))*\s*>\s*$""")


@dataclass(frozen=True)
class Message:
    """A message's text and the line of the stream where it begins, from 1; `sender` tells streams apart."""

    text: str
    line: int
    sender: str = field(default="", repr=False, compare=False)


class Messages:
    r"""Takes lines, gives messages.

    Parameters
    ----------
    commands : collection of str
        Names of elements that may be left open.
    texts : bool
        Whether a line that is no element is a message too (text to be spoken).

    Examples
    --------
    >>> messages = Messages({"HeadNod"})
    >>> messages.take('<HeadNod at="0"') + messages.take('count="2">') + messages.finish()
    [Message(text='<HeadNod at="0"\ncount="2"/>', line=1)]
    """

    def __init__(self, commands: Collection[str], texts: bool = False) -> None:
        self.commands, self.texts = commands, texts
        self.lines: list[str] = []
        self.begun = 0
        self.count = 0
        self.size = 0
        self.elements = 0
        self.root = self.until = ""

    def take(self, line: str) -> list[Message]:
        """The messages that a further line completes.

        Raises
        ------
        InputError
            If a message is too long.
        """
        self.count += 1
        line = line.rstrip("\r\n")
        done: list[Message] = []
        if self.lines and self._left_open(line):
            done.append(self._closed())
        if not self.lines:
            if not line.strip():
                return done
            self.begun = self.count
        self.lines.append(line)
        self.size += len(line)
        self.elements += line.count("<")
        if self.size > MOST_CHARACTERS:
            self._clear()
            raise InputError(f"line {self.begun}: a message of more than {MOST_CHARACTERS} characters")
        if self._complete():
            done.append(Message(self._clear(), self.begun))
        return done

    def finish(self) -> list[Message]:
        """What is left at the end: a command that was left open, or half a message (which its reader will refuse)."""
        if not self.lines:
            return []
        return [self._closed() if self._is_lone() else Message(self._clear(), self.begun)]

    def _clear(self) -> str:
        text = "\n".join(self.lines)
        self.lines, self.size, self.elements, self.root, self.until = [], 0, 0, "", ""
        return text

    def _closed(self) -> Message:
        return Message(self._clear().rstrip()[:-1] + "/>", self.begun)

    def _is_lone(self) -> bool:
        found = _LONE_OPEN.match("\n".join(self.lines))
        return found is not None and found[1] in self.commands

    def _left_open(self, line: str) -> bool:
        """Whether the command under way was left open, since something else begins."""
        if len(self.lines) > _OPEN_LINES or not self._is_lone():
            return False
        name = _NAME.match("\n".join(self.lines))
        closing = name is not None and line.lstrip().startswith((f"</{name[1]}", "<key", "<!--"))
        return bool(line.strip()) and not closing

    def _complete(self) -> bool:
        """Whether the last line ends the message; looks at it alone, so that long ones cost what they hold."""
        line = self.lines[-1]
        if self.lines[0].lstrip().startswith(("<?xml", "<!--", "<!DOCTYPE")):
            self._pass_prolog(line)
            return self.root != "" and self._closes(self.root)
        first = _NAME.match(self.lines[0])
        if self.texts and (first is None or first[1].rpartition(":")[2] not in ROOTS):
            # Text with tags: a line, unless it ends inside a tag, or is a command that was left open.
            if len(self.lines) > 1 and "<" not in line and ">" not in line:
                return False
            cut = _CUT.search(line)
            return (cut is None or cut[1] not in self.commands) and not (
                len(self.lines) <= _OPEN_LINES and self._is_lone()
            )
        if first is None:
            return True
        return self._closes(first[1]) or (line.rstrip().endswith("/>") and self.elements == 1)

    def _closes(self, name: str) -> bool:
        tail = "\n".join(self.lines[-2:]) if ">" in self.lines[-1] else ""
        return re.search(rf"</{re.escape(name)}\s*>\s*$", tail) is not None

    def _pass_prolog(self, line: str) -> None:
        """Find the root's name behind declarations and remarks, which may go over many lines."""
        at = 0
        while not self.root:
            if self.until:
                end = line.find(self.until, at)
                if end < 0:
                    return
                at, self.until = end + len(self.until), ""
                continue
            at = line.find("<", at)
            if at < 0:
                return
            name = _NAME.match(line, at)
            self.root = name[1] if name else ""
            self.until = next((end for begin, end in _PROLOG.items() if line.startswith(begin, at)), "")
            at += 1

"""Cameras and lights by name, the same for the page and for pictures that are exported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mien.core.errors import unknown_name
from mien.face.render.lighting import known_lightings
from mien.face.render.view import View
from mien.serve.studio.requests import FieldError

__all__ = ["CAMERAS", "LIGHTS", "Shown"]

_OF_THE_PAGE = {"portrait": "portrait", "three-quarter": "three-quarter", "profile": "side", "mouth": "mouth"}
CAMERAS = tuple(_OF_THE_PAGE)
LIGHTS = known_lightings()


@dataclass(frozen=True)
class Shown:
    """What an export shows, and how.

    Attributes
    ----------
    face, rig : object
        Ids of the page's, checked where they are looked up; None: the default face, moved by its morph targets.
    camera, light : str
        Of `CAMERAS` and `LIGHTS`.
    """

    face: object = None
    rig: object = None
    camera: str = "portrait"
    light: str = "portrait"

    @classmethod
    def of(cls, asked: Mapping[str, Any]) -> Shown:
        """Read from a request.

        Raises
        ------
        FieldError
            If a camera or light is not known.
        """
        chosen = {"camera": CAMERAS, "light": LIGHTS}
        for field, known in chosen.items():
            name = asked.get(field)
            if name is not None and name not in tuple(known):
                raise FieldError(field, str(unknown_name(field, str(name)[:40], known)))
        camera, light = asked.get("camera") or "portrait", asked.get("light") or "portrait"
        return cls(asked.get("face"), asked.get("rig"), camera, light)

    def view(self) -> View:
        """How exported pictures show a face."""
        return View(camera=_OF_THE_PAGE[self.camera], light=self.light)

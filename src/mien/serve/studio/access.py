"""Who may ask the studio for what: the checks that every request passes, and the headers that every answer carries.

* ``Host`` must name this machine, so that a page elsewhere cannot reach the studio under a name of its own that it
  points here (DNS rebinding).
* ``Origin`` and ``Sec-Fetch-Site``, where a browser sends them, must be the studio's own page.
* With a token, a request carries it: in the header ``Authorization: Bearer TOKEN``, or as the cookie that the page's
  address ``/?token=TOKEN`` was answered with. Tokens are compared in constant time.
"""

from __future__ import annotations

import secrets
from urllib.parse import urlsplit

from aiohttp import hdrs, web

from mien.serve.addresses import is_loopback
from mien.serve.studio.settings import StudioSettings

__all__ = ["COOKIE", "HEADERS", "Gate"]

COOKIE = "mien_studio"
_POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; media-src 'self' blob: data:; font-src 'self' data:; "
    "connect-src 'self' blob: data:; worker-src 'self' blob:; manifest-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(self)",
}
"""What every answer carries."""


class Gate:
    """Decides on requests.

    Parameters
    ----------
    settings : StudioSettings
    """

    def __init__(self, settings: StudioSettings) -> None:
        self._settings = settings
        self._names = {"localhost", settings.host.lower(), *(name.lower() for name in settings.names)}

    def refusal(self, request: web.Request) -> web.Response | None:
        """Why a request is turned away, or None; also the answer that gives a browser its cookie."""
        if not self._known_name(request.headers.get(hdrs.HOST, "")):
            return _refused(403, "the studio is not reached under this name: use the address that it printed")
        if not _own_page(request):
            return _refused(403, "pages of other sites may not use the studio")
        if self._settings.token is None:
            return None
        if request.method == "GET" and request.path == "/" and "token" in request.query:
            return self._welcome(request.query["token"])
        if self._has_token(request):
            return None
        return _refused(401, "the token is missing or wrong: open the address that the studio printed")

    def _known_name(self, host: str) -> bool:
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if not name:
            return False
        return self._settings.token is not None or name in self._names or is_loopback(name)

    def _has_token(self, request: web.Request) -> bool:
        session = request.cookies.get(COOKIE, "")
        if secrets.compare_digest(session.encode("utf-8", "replace"), self._settings.session.encode()):
            return True
        kind, _, given = request.headers.get(hdrs.AUTHORIZATION, "").partition(" ")
        return kind.lower() == "bearer" and self._is_token(given.strip())

    def _is_token(self, given: str) -> bool:
        expected = self._settings.token or ""
        return secrets.compare_digest(given.encode("utf-8", "replace"), expected.encode())

    def _welcome(self, given: str) -> web.Response:
        if not self._is_token(given):
            return _refused(401, "the token is wrong: open the address that the studio printed")
        answer = web.Response(status=303, headers={hdrs.LOCATION: "/", **HEADERS})
        answer.set_cookie(COOKIE, self._settings.session, httponly=True, samesite="Strict", path="/")
        return answer


def _own_page(request: web.Request) -> bool:
    """Whether a request comes from the studio's page, from no page at all, or opens the page."""
    origin = request.headers.get(hdrs.ORIGIN)
    if origin is not None:
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return parts.scheme in ("http", "https") and parts.netloc.lower() == request.headers.get(hdrs.HOST, "").lower()
    from_where = request.headers.get("Sec-Fetch-Site", "none")
    opens_page = request.method in ("GET", "HEAD") and request.path == "/"
    return from_where in ("same-origin", "none") or opens_page


def _refused(status: int, told: str) -> web.Response:
    return web.json_response({"error": told, "field": None}, status=status, headers={**HEADERS, "Connection": "close"})

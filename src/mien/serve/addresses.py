"""Who can reach an address, and the rule for all that listens: this machine alone, or a token."""

from __future__ import annotations

import ipaddress

from mien.core.errors import InputError

__all__ = ["check_address", "is_loopback"]


def check_address(host: str, port: int, token: str | None) -> None:
    """Refuse an address that others can reach without a token, and ports and tokens that are none.

    Raises
    ------
    InputError
    """
    if not 0 <= port <= 65535:
        raise InputError(f"a port runs from 0 to 65535, not {port}")
    if token is not None and len(token) < 8:
        raise InputError("a token has at least 8 characters")
    if token is None and not is_loopback(host):
        raise InputError(f"{host} can be reached by other machines: give --token, which every client must know")


def is_loopback(host: str) -> bool:
    """Whether an address is this machine's own.

    Examples
    --------
    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("0.0.0.0"), is_loopback("example.org")
    (True, True, False, False)
    """
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False

"""`FieldError`: what is wrong with a request, and where."""

from mien.core.errors import InputError

__all__ = ["FieldError"]


class FieldError(InputError):
    """A field of a request cannot be used."""

    def __init__(self, field: str, message: str) -> None:
        super().__init__(message)
        self.field = field

"""What can go wrong, said with place, value and remedy."""


class FbfError(Exception):
    """An error a user can act on. `str()` of it is one line, ready for stderr."""

    exit_code = 1


class GcodeError(FbfError):
    """A line of G-code that cannot be processed safely."""

    def __init__(self, why: str, *, file: str = "", line: int | None = None, text: str = "", remedy: str = ""):
        self.why, self.file, self.line, self.text, self.remedy = why, file, line, text, remedy
        super().__init__(why)

    def at(self, file: str) -> "GcodeError":
        """The same error, with the file's name."""
        return GcodeError(self.why, file=file, line=self.line, text=self.text, remedy=self.remedy)

    def __str__(self) -> str:
        place = ":".join(str(p) for p in (self.file, self.line) if p not in ("", None))
        quote = f": {self.text.strip()[:80]!r}" if self.text else ""
        remedy = f" ({self.remedy})" if self.remedy else ""
        return f"{place + ': ' if place else ''}{self.why}{quote}{remedy}"


class ProfileError(FbfError):
    """A printer profile that cannot be used."""


class ModelError(FbfError):
    """A plant model that is unstable, or that no compensator can be designed for."""


class LimitError(FbfError):
    """A command that would leave the printer's limits."""


class ControlError(FbfError):
    """A method asked for what it is not defined for: a basis, a zero on the unit circle, matrices that do not fit."""


class RecordingError(FbfError):
    """A recording that cannot be read, or that does not hold what is asked of it."""

    def __init__(self, why: str, *, file: str = "", line: int | None = None, text: str = "", remedy: str = ""):
        place = ":".join(str(p) for p in (file, line) if p not in ("", None))
        quote = f": {text.strip()[:80]!r}" if text else ""
        super().__init__(f"{place + ': ' if place else ''}{why}{quote}{f' ({remedy})' if remedy else ''}")

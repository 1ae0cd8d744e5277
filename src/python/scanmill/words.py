"""Suggestions in messages about unknown words."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from ._core import InputError


def advice(word: str, known: Iterable[str]) -> str:
    """Returns the end of a message about an unknown word: a similar known word, or all known words if none is
    similar."""
    names = [str(name) for name in known]
    near = difflib.get_close_matches(str(word), names, 1)
    if near:
        return f" (did you mean '{near[0]}'?)"
    return f" (known: {', '.join(names)})" if names else ""


def require_known(what: str, word: str, known: Iterable[str]) -> None:
    """Raises InputError with the message "unknown WHAT 'WORD'" and a suggestion, if the word is not one of `known`."""
    names = list(known)
    if word not in names:
        raise InputError(f"unknown {what} '{word}'{advice(word, names)}")

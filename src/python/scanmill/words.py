"""Suggestions in messages about unknown words."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

from ._core import InputError


def advice(word: str, known: Iterable[str]) -> str:
    """Returns the end of a message about an unknown word: a similar known word, or all known words if none is
    similar."""
    names = [str(name) for name in known]
    near = difflib.get_close_matches(str(word), names, 1)
    if near:
        return f" (did you mean '{near[0]}'?)"
    return f" (known: {', '.join(names)})" if names else ""


def names_in(what: str, values: Any) -> list[str]:
    """Returns the names as a list. Raises InputError unless `values` is a list or another iterable of texts."""
    names = list(values) if isinstance(values, Iterable) and not isinstance(values, str) else [None]
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{what} must be a list of names, not {values!r}")
    return names


def require_known(what: str, word: str, known: Iterable[str]) -> None:
    """Raises InputError with the message "unknown WHAT 'WORD'" and a suggestion, if the word is not one of `known`."""
    names = list(known)
    if word not in names:
        raise InputError(f"unknown {what} '{word}'{advice(word, names)}")

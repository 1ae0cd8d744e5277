"""Advice for words that are not known."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from ._core import InputError


def advice(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown word: the nearest known one, or all of them where none is near."""
    names = [str(name) for name in known]
    near = difflib.get_close_matches(str(word), names, 1)
    if near:
        return f" (did you mean '{near[0]}'?)"
    return f" (known: {', '.join(names)})" if names else ""


def require_known(what: str, word: str, known: Iterable[str]) -> None:
    """Raise an InputError, "unknown WHAT 'WORD'" with advice, unless the word is one of `known`."""
    names = list(known)
    if word not in names:
        raise InputError(f"unknown {what} '{word}'{advice(word, names)}")

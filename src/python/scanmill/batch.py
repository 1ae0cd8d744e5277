"""Combines arrays of different lengths to one array."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError


def pad_batch(arrays: Sequence[NDArray[Any]], fill: float = 0) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Returns B arrays (N_i, ...) as one array (B, Nmax, ...), and a bool mask (B, Nmax) that is True for their
    entries.

    Shorter arrays are padded with `fill` at the end. Raises InputError for an empty list, and if the arrays differ in
    their type or in other dimensions than their length.
    """
    if not len(arrays):
        raise InputError("a batch must have at least one array")
    first = arrays[0]
    if any(a.shape[1:] != first.shape[1:] or a.dtype != first.dtype for a in arrays):
        raise InputError("the arrays of a batch must have the same type, and the same shape except for their length")
    longest = max(len(a) for a in arrays)
    out = np.full((len(arrays), longest, *first.shape[1:]), fill, first.dtype)
    mask = np.zeros((len(arrays), longest), bool)
    for row, filled, a in zip(out, mask, arrays):
        row[: len(a)] = a
        filled[: len(a)] = True
    return out, mask

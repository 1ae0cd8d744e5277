"""Reads NumPy archives (.npz) from untrusted sources: checks the sizes that they state before it allocates memory."""

from __future__ import annotations

import io
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import InputError

HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def read_npz(archive: bytes, name: str) -> dict[str, NDArray[Any]]:
    """Returns the arrays of an archive. `name` is its name in messages.

    Raises InputError for an archive whose stated contents are larger than 1 GiB plus 64 times its own size, that is
    damaged, or that has anything but arrays of numbers.
    """
    most = (1 << 30) + 64 * len(archive)
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as members:
            stated = sum(member.file_size for member in members.infolist())
            if stated > most:
                raise InputError(
                    f"{name}: states {stated} bytes, but an archive of {len(archive)} bytes may have at most {most}"
                )
            return {m.filename.removesuffix(".npy"): _read_npy(members, m) for m in members.infolist()}
    except InputError:
        raise
    except (ValueError, TypeError, LookupError, RuntimeError, EOFError, OSError, zipfile.BadZipFile, zlib.error) as e:
        raise InputError(f"{name}: cannot be read: {e}") from None


def _read_npy(members: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    # For other kinds of compression, zipfile does not enforce the size that a member states.
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{member.filename} is not compressed by deflate")
    content = members.read(member)
    file = io.BytesIO(content)
    shape, fortran, dtype = HEADERS[np.lib.format.read_magic(file)](file)
    if dtype.hasobject or min(shape, default=0) < 0:
        raise ValueError(f"{member.filename} has objects of Python, or no shape")
    # numpy.load() would allocate whatever the header states.
    return np.ndarray(shape, dtype, content, file.tell(), order="F" if fortran else "C").copy()

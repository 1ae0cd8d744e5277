"""Loads libraries that a wheel brings for systems that lack them. The system's own goes first: graphics drivers link them, too."""

import ctypes
from pathlib import Path


def load_missing():
    missing = []
    for folder in (Path(__file__).resolve().parent / "lib" / "fallback").glob("*.so*"):
        try:
            ctypes.CDLL(folder.name)
        except OSError:
            missing.append(folder / folder.name)
    # One may need another: again and again until nothing more can be loaded.
    while missing:
        left = []
        for library in missing:
            try:
                ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
            except OSError:
                left.append(library)
        if len(left) == len(missing):
            return  # what needs them says so
        missing = left

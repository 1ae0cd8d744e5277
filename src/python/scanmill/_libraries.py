"""Loads libraries of a wheel that the system lacks. The system's libraries come first, since graphics drivers use them
too."""

import ctypes
from pathlib import Path


def load_missing():
    missing = []
    for folder in (Path(__file__).resolve().parent / "lib" / "fallback").glob("*.so*"):
        try:
            ctypes.CDLL(folder.name)
        except OSError:
            missing.append(folder / folder.name)
    # A library may need another one of them, so repeat until no further library can be loaded.
    while missing:
        unloaded = []
        for library in missing:
            try:
                ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
            except OSError:
                unloaded.append(library)
        if len(unloaded) == len(missing):
            return  # the extension reports missing libraries when it is imported
        missing = unloaded

"""What tests of the program share."""

import hashlib
import os
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SCANMILL", str(ROOT / "build/release/scanmill"))
HIDDEN = ".scanmill"  # the folder in which an unfinished dataset is made


def tree(folder, hidden=True):
    """Every name in a folder, with the SHA-256 of files, the targets of links, and None for folders."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if not hidden and name.parts[0] == HIDDEN:
            continue
        if path.is_symlink():
            found[str(name)] = f"-> {os.readlink(path)}"
        else:
            found[str(name)] = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
    return found


def wait_until(what, holds, patience_s=120):
    """The first value of `holds()` that is true."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        if value := holds():
            return value
        time.sleep(0.002)
    raise AssertionError(f"waited {patience_s} s in vain: {what}")

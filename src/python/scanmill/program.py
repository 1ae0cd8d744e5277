"""The command `scanmill` of a wheel that contains the program and its libraries."""

import os
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def main():
    program = PACKAGE / "bin" / "scanmill"
    if not program.exists():
        sys.exit("error: this package has no program: a wheel made by scripts/packages has")
    os.environ.setdefault("SCANMILL_RESOURCES", str(PACKAGE / "share"))
    # The folder with libraries that this system lacks; empty if it has all.
    path = subprocess.run(["sh", PACKAGE / "lib" / "fallback" / "path"], capture_output=True, text=True, check=True).stdout.strip()
    if path:
        os.environ["LD_LIBRARY_PATH"] = path
    os.execv(program, [str(program), *sys.argv[1:]])


if __name__ == "__main__":
    main()

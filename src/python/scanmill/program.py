"""The command `scanmill` of a wheel that contains the program."""

import os
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def main():
    program = PACKAGE / "bin" / "scanmill"
    if not program.exists():
        sys.exit("error: this package was built without the program (SCANMILL_STUDIO=OFF)")
    os.environ.setdefault("SCANMILL_RESOURCES", str(PACKAGE / "share"))
    # Tells the folder with libraries that this system lacks; empty if it has all. Only a wheel of scripts/packages has it.
    fallback = PACKAGE / "lib" / "fallback" / "path"
    path = fallback.exists() and subprocess.run(["sh", fallback], capture_output=True, text=True, check=True).stdout.strip()
    if path:
        os.environ["LD_LIBRARY_PATH"] = path
    os.execv(program, [str(program), *sys.argv[1:]])


if __name__ == "__main__":
    main()

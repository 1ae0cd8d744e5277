"""Builds wheels of the package with CMake (PEP 517), using only Python's standard library.

`pip install .` calls build_wheel(); `pip install -e .` is not supported. `scripts/setup` installs the libraries that
the extension and the program need. If the environment variable SCANMILL_BUILD names a build folder, that build is used;
one that was configured without the program makes a wheel without it.

With SCANMILL_BUNDLE=1 the wheel contains all libraries, too, for machines without a compiler, root or Debian;
`scripts/packages` uses this. Large libraries that are seldom needed are left out (LEFT_OUT).
"""

import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def get_requires_for_build_wheel(config_settings=None):
    return []


def version():
    return re.search(r"project\(scanmill VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)


def metadata():
    return (
        f"Metadata-Version: 2.1\nName: scanmill\nVersion: {version()}\n"
        "Summary: Labelled LiDAR datasets from 3D scenes: read them as numpy arrays, and scan scenes from Python\n"
        "License: Apache-2.0\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
    )


def tag():
    interpreter = "cp" + sysconfig.get_config_var("py_version_nodot")
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    if bundled():  # pip then refuses the wheel on systems with an older glibc
        platform = platform.replace("linux", "manylinux_" + os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_"))
    return f"{interpreter}-{interpreter}-{platform}"


# Plug-ins that a bundled wheel leaves out: images except PNG and JPEG (OpenImageIO has 200 MB of codecs), rasters (GDAL).
LEFT_OUT = ("libscanmill_images.so", "libscanmill_rasters.so")


def bundled():
    return os.environ.get("SCANMILL_BUNDLE", "0") not in ("", "0")


def has_program(build):
    return "SCANMILL_STUDIO:BOOL=ON" in (build / "CMakeCache.txt").read_text()


def add_program(build, package):
    (package / "bin").mkdir()
    shutil.copy(build / "scanmill", package / "bin" / "scanmill")
    shutil.copy(next(build.glob("lib*/**/libscanmill_viewer.so")), package / "lib")


def bundle(package):
    """Copies all libraries that the program and the extension are linked to into the package."""
    for name in LEFT_OUT:
        (package / "lib" / name).unlink()
    files = [package / "bin" / "scanmill", *package.glob("_core*.so"), *(package / "lib").glob("*.so")]
    subprocess.run([ROOT / "scripts" / "bundle_libraries", package, *files], check=True)


def check_interpreter(build):
    """Exits with a message if the build's extension is for another version of Python than the one that is running."""
    cache = (build / "CMakeCache.txt").read_text()
    found = re.search(r"^PYTHON_MODULE_EXTENSION:\w+=(.*)$", cache, re.MULTILINE)
    wanted = sysconfig.get_config_var("EXT_SUFFIX")
    if not found:
        sys.exit(f"error: {build} was configured without the Python package: -DSCANMILL_PYTHON=ON (scripts/build does it), or "
                 "name a new folder by SCANMILL_BUILD, in which it is built")
    if found[1] != wanted:
        sys.exit(f"error: {build} has the extension for another Python ({found[1]}) than {sys.executable} ({wanted}): make the "
                 "environment with the Python of the build, such as /usr/bin/python3, or name a new folder by SCANMILL_BUILD, in "
                 "which the extension is built for this one")


def source_of(build):
    """Returns the source tree that a build folder was configured for; None if it was not configured."""
    cache = build / "CMakeCache.txt"
    found = re.search(r"^CMAKE_HOME_DIRECTORY:\w+=(.*)$", cache.read_text(), re.MULTILINE) if cache.exists() else None
    return found and Path(found[1]).resolve()


def built():
    """Builds the package and returns the folder into which CMake has installed it."""
    build = Path(os.environ.get("SCANMILL_BUILD", ROOT / "build" / "python"))
    source = source_of(build)
    if source and source != ROOT and "SCANMILL_BUILD" in os.environ:
        sys.exit(f"error: {build} is the build of {source}, not of {ROOT}: name another folder by SCANMILL_BUILD")
    if source != ROOT:  # the folder was moved or copied, or is new
        options = ["-DCMAKE_BUILD_TYPE=Release", "-DSCANMILL_STUDIO=ON", "-DSCANMILL_TESTS=OFF", "-DSCANMILL_PYTHON=ON",
                   f"-DPython_EXECUTABLE={sys.executable}"]
        subprocess.run(["cmake", "--fresh", "-S", ROOT, "-B", build, "-G", "Ninja", *options], check=True)
    check_interpreter(build)
    targets = ["scanmill_python", "scanmill"] if has_program(build) else ["scanmill_python"]
    subprocess.run(["cmake", "--build", build, "--target", *targets], check=True)
    staging = build / "wheel"
    shutil.rmtree(staging, ignore_errors=True)
    subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", staging], check=True)
    site = staging / "lib" / "python3" / "dist-packages"
    if has_program(build):
        add_program(build, site / "scanmill")
    if bundled():
        bundle(site / "scanmill")
    return site


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    staging = built()
    files = {p.relative_to(staging).as_posix(): p for p in sorted(staging.rglob("*")) if p.is_file()}
    info = f"scanmill-{version()}.dist-info"
    texts = {
        f"{info}/METADATA": metadata(),
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nGenerator: scanmill\nRoot-Is-Purelib: false\nTag: {tag()}\n",
        f"{info}/LICENSE": (ROOT / "LICENSE").read_text(),
    }
    if "scanmill/bin/scanmill" in files:
        texts[f"{info}/entry_points.txt"] = "[console_scripts]\nscanmill = scanmill.program:main\n"
    name = f"scanmill-{version()}-{tag()}.whl"
    record = []
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for where, data in [(n, p.read_bytes()) for n, p in files.items()] + [(n, t.encode()) for n, t in texts.items()]:
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{where},sha256={digest},{len(data)}")
            entry = zipfile.ZipInfo(where, (1980, 1, 1, 0, 0, 0))  # a constant time makes the wheel reproducible
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if where in files and os.access(files[where], os.X_OK) else 0o100644) << 16
            wheel.writestr(entry, data)
        record.append(f"{info}/RECORD,,")
        wheel.writestr(f"{info}/RECORD", "\n".join(record) + "\n")
    return name

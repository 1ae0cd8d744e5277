"""Makes, plans, checks and exports datasets, as the commands of these names do."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
import time
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

from . import _core
from ._core import InputError, Job
from .dataset import Dataset, Path, open_dataset

Pipeline = Union[Path, Mapping[str, Any]]
Keys = Optional[Mapping[str, Any]]

LINE_SECONDS = 5.0  # between lines of progress


def generate(
    pipeline: Pipeline,
    out: Path,
    *,
    set: Keys = None,
    seed: int | None = None,
    overwrite: bool = False,
    resume: bool = False,
    threads: int = 0,
    quiet: bool = False,
) -> Dataset:
    """Makes the dataset of a pipeline in the folder `out`, and opens it.

        dataset = scanmill.generate("quickstart", "out/quickstart", set={"scenes.0.seeds": [4, 5], "splits": None})

    `pipeline`: the path of a file, the name of a pipeline that comes with the program, or a map with the keys of a
    pipeline (docs/keys.md), whose relative paths start at the current folder. `set`: values for keys of the pipeline,
    as the option --set has them; `seed`: the value of its key `seed`. `overwrite` replaces a dataset in the folder;
    `resume` continues an unfinished one, and keeps a complete one. `threads`: 0 for all cores. The bytes are those of
    the command.

    Shows a bar if tqdm is installed, otherwise lines; nothing if `quiet`. Ctrl-C stops after the present samples;
    `resume` then continues. What the command warns of are warnings of Python. Raises InputError for what is wrong in
    pipeline, scenes or folder.
    """
    text, is_text, overrides = _pipeline(pipeline, set, seed)
    job = _core.generate(text, is_text, overrides, os.getcwd(), os.path.abspath(out), overwrite, resume, threads)
    _finished(job, "generate", quiet)
    return open_dataset(out)


def plan(pipeline: Pipeline, *, set: Keys = None, seed: int | None = None) -> dict[str, Any]:
    """Returns what a pipeline makes: numbers of `samples` and `rays`, `shards` by split, `sequences`, and what is
    `modelled` and `left_out`, in lines. Reads no scenes. The arguments are those of generate(). Raises InputError."""
    found: dict[str, Any] = json.loads(_core.plan(*_pipeline(pipeline, set, seed), os.getcwd()))
    return found


def export(
    dataset: Path | Dataset,
    to: str,
    out: Path,
    *,
    classes: str = "",
    sensors: Sequence[str] = (),
    splits: Sequence[str] = (),
    overwrite: bool = False,
    quiet: bool = False,
) -> None:
    """Writes a dataset in another layout to the folder `out`: scanmill.export(dataset, "semantic_kitti", "out/kitti").

    `classes`: an ontology in place of the layout's, a file or a name. `sensors`, `splits`: names; none: all. Progress,
    warnings and errors are as of generate()."""
    job = _core.export(_folder(dataset), to, os.path.abspath(out), classes, list(sensors), list(splits), overwrite)
    _finished(job, "export", quiet)


def verify(dataset: Path | Dataset, *, quiet: bool = False) -> list[str]:
    """Checks every byte of a dataset, and returns the problems, a line each; an empty list if it is sound."""
    return _finished(_core.verify(_folder(dataset)), "verify", quiet)


def picture(what: Path | Dataset, out: Path, **options: str | float | bool | Sequence[str]) -> str:
    """Writes a picture of a dataset, a scan or a scene to the file `out` (PNG), and returns its path.

        scanmill.picture("out/quickstart", "town.png", size="1280x720", hide=["road", "sidewalk"], bare=True)

    `options`: those of `scanmill view`, with "_" for "-"; a list repeats an option. It runs the program of the wheel, else
    the one that the variable SCANMILL names, else the shell's; no display is needed. Raises InputError as the command does."""
    bundled = (pathlib.Path(__file__).parent / "bin" / "scanmill").exists()
    program = [sys.executable, "-m", "scanmill"] if bundled else [os.environ.get("SCANMILL", "scanmill")]
    command = [*program, "view", _folder(what), "--screenshot", os.path.abspath(out)]
    for name, value in options.items():
        for one in [value] if isinstance(value, (str, float, int)) else value:
            command.append(f"--{name.replace('_', '-')}" + ("" if one is True else f"={one}"))
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except FileNotFoundError:
        raise InputError("picture() runs the program `scanmill`: put it on PATH, or name it in the variable SCANMILL") from None
    if done.returncode != 0:
        raise InputError(done.stderr.strip().removeprefix("error: "))
    return os.path.abspath(out)


def _folder(dataset: Path | Dataset) -> str:
    return os.path.abspath(dataset.store.path if isinstance(dataset, Dataset) else dataset)


def _pipeline(pipeline: Pipeline, keys: Keys, seed: int | None) -> tuple[str, bool, list[str]]:
    """Returns path, name or text of a pipeline, whether it is a text, and the overrides KEY=VALUE."""
    values = {**(keys or {}), **({} if seed is None else {"seed": seed})}
    try:
        overrides = [f"{key}={json.dumps(value)}" for key, value in values.items()]
        if isinstance(pipeline, Mapping):
            return json.dumps(dict(pipeline)), True, overrides
    except (TypeError, ValueError) as error:
        raise InputError(f"a pipeline holds maps, lists, texts and numbers: {error}") from None
    return os.fspath(pipeline), False, overrides


def _finished(job: Job, what: str, quiet: bool) -> list[str]:
    """Shows how far a job is until it ends, warns of what it warns of, and returns the problems that it has found.
    Stops it if Python is interrupted."""
    show = _Lines(what) if quiet or _tqdm() is None else _Bar(what)
    try:
        while not job.wait(0.2):
            if not quiet:
                show(*job.progress)
    except BaseException:
        job.stop()
        while not job.wait(60):
            pass
        raise
    if not quiet:
        show(*job.progress, end=True)
    for line in job.warnings:
        warnings.warn(line, stacklevel=3)
    return job.result()


def _tqdm() -> Any:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # notebooks without widgets get tqdm's bar of text
            from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm


class _Bar:
    """Shows progress by a bar of tqdm."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.bar: Any = None

    def __call__(self, stage: str, done: int, total: int, end: bool = False) -> None:
        if self.bar is None and total:
            self.bar = _tqdm()(total=total, desc=self.what, unit=stage.split(",")[0].rstrip("s"))
        if self.bar is not None:
            self.bar.n = done
            self.bar.refresh()
            if end:
                self.bar.close()


class _Lines:
    """Shows progress by a line every few seconds, on standard error."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.start = self.shown = time.monotonic()

    def __call__(self, stage: str, done: int, total: int, end: bool = False) -> None:
        now = time.monotonic()
        if not total or now - self.shown < LINE_SECONDS and not end:
            return
        self.shown = now
        left = "" if end or not done else f", about {(now - self.start) * (total - done) / done:.0f} s left"
        print(f"{self.what}: {done} of {total} {stage}{left}", file=sys.stderr, flush=True)

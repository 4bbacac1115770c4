"""The commands of `bedload` as functions."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, SupportsFloat

from ._program import BedloadError, Progress, call, listener
from ._scene import Scene, file_of, path_of, read, settings

if TYPE_CHECKING:
    from ._results import Run, Table


def _options(**values: object) -> list[object]:
    """`--name VALUE` of each that is not None or False; `--name` alone of those that are True."""
    words: list[object] = []
    for name, value in values.items():
        if value is not None and value is not False:
            words += [f"--{name.replace('_', '-')}"] + ([] if value is True else [value])
    return words


def _stem(scene: Scene) -> str:
    path = path_of(scene)
    return "scene" if path is None else path.stem


def _number(name: str, value: float | None) -> str | None:
    """A number as an option has it."""
    if value is None:
        return None
    if isinstance(value, SupportsFloat) and isfinite(value):
        return repr(float(value))
    raise TypeError(f"{name}: {value!r}; remedy: a finite number")


def _end(file: Path, set: Mapping[str, Any] | None, until: float | None) -> float:
    """End of a run, s; infinite where the scene does not say it in a way that can be read here."""
    try:
        return float(until if until is not None else {**read(file), **(set or {})}["until"])
    except (OSError, ValueError, KeyError, TypeError):
        return inf


def run(
    scene: Scene,
    out: str | os.PathLike[str] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    until: float | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    record: bool = True,
    accuracy: str | None = None,
    verify: bool = False,
    progress: bool | Callable[[Progress], object] | None = None,
) -> Run:
    """Runs a scene to its end, as `bedload run` does, and returns its results.

    `scene` is a file or a dictionary, whose files are looked up from the current folder. `out` is the output
    folder, by default out/NAME; `set` changes keys, such as {"grains[0].density": 2.0}; `until` is the end,
    s; `threads` those of each solver; `resume` goes on from the checkpoint in `out`; `overwrite` replaces a
    finished run there; `record=False` leaves out the log; `accuracy`, such as "2%", and `verify` as in
    docs/resolution.md. `progress=True` prints what the program says; a function is given each `Progress`:
    of the start, every two seconds, and of the end.

    Ctrl-C ends the run in order, with a checkpoint from which `resume=True` goes on.
    Raises BedloadError if the run fails; its folder is `out` of the error.
    """
    from ._results import Run

    folder = Path(out) if out is not None else Path("out", _stem(scene))
    if not isinstance(record, bool):
        raise TypeError(f"record: {record!r}; remedy: True or False")
    words = _options(
        out=folder,
        until=_number("until", until),
        threads=threads,
        resume=resume,
        overwrite=overwrite,
        no_record=not record,
        accuracy=accuracy,
        verify=verify,
    )
    with file_of(scene) as file:
        if callable(progress):
            progress(Progress(0.0, _end(file, set, until), "starts"))
        try:
            call("run", file, *words, *settings(set), line=listener(progress))
        except BedloadError as error:
            error.out = folder
            raise
    result = Run(folder)
    if callable(progress):
        time = result.summary["time"]["simulated"]
        progress(Progress(time, time, "done"))
    return result


def check(
    scene: Scene,
    *,
    set: Mapping[str, Any] | None = None,
    until: float | None = None,
    accuracy: str | None = None,
    allow_commands: bool = False,
) -> dict[str, Any]:
    """The plan of a scene, as `bedload check --json` prints it: steps, sub-steps, bounds with their margins,
    cost.

    `allow_commands` lets solvers that the scene names be asked. Raises BedloadError if the scene is wrong, or
    if it breaks a bound: then the plan is in `plan` of the error."""
    words = _options(
        until=_number("until", until), accuracy=accuracy, allow_commands=allow_commands
    )
    with file_of(scene) as file:
        try:
            plan: dict[str, Any] = json.loads(call("check", file, "--json", *words, *settings(set)))
        except BedloadError as error:
            error.plan = json.loads(error.printed) if error.printed.startswith("{") else None
            raise
    return plan


def replay(
    log: str | os.PathLike[str],
    drive: str,
    *,
    verify: bool = False,
    set: Mapping[str, Any] | None = None,
    compare: bool = False,
    checkpoint: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] | None = None,
    allow_commands: bool = False,
    progress: bool | Callable[[Progress], object] | None = None,
) -> Table | None:
    """Drives one solver, `dem` or `fluid`, from the log of a run, as `bedload replay` does
    (docs/coupling.md).

    With `set` or `compare`, and `out`, returns how far each quantity is from the logged one:
    `divergence.csv`. Raises BedloadError if the solver fails or, with `verify`, at the first difference."""
    words = _options(
        drive=drive,
        verify=verify,
        compare=compare,
        checkpoint=checkpoint,
        out=out,
        allow_commands=allow_commands,
    )
    call("replay", log, *words, *settings(set), line=listener(progress))
    from ._results import read_table

    table = None if out is None else Path(out, "divergence.csv")
    return read_table(table) if table and table.is_file() else None


def study(
    *files: str | os.PathLike[str],
    out: str | os.PathLike[str],
    jobs: int | None = None,
    progress: bool | Callable[[Progress], object] | None = None,
) -> Path:
    """Makes the charts, maps and cases of these files, as `bedload study` does: tables, figures and pages in
    `out`. Finished runs in it are not repeated. Returns `out`."""
    if not files:
        raise BedloadError(2, "a study needs a file; remedy: name one with [chart], [stability] or [case]")
    call("study", *files, *_options(out=out, jobs=jobs), line=listener(progress))
    return Path(out)


def ensemble(
    scene: Scene | Sequence[str | os.PathLike[str]],
    seeds: int,
    *,
    set: Mapping[str, Any] | None = None,
    until: float | None = None,
    jobs: int | None = None,
    out: str | os.PathLike[str] | None = None,
    progress: bool | Callable[[Progress], object] | None = None,
) -> Table:
    """Runs a scene, or a chain of scene files, once for each seed, as `bedload ensemble` does, in the folder
    `out`, by default out/NAME-ensemble. Finished runs in it are kept. Returns its `ensemble.csv`: means and
    standard errors.

    Raises BedloadError if a seed failed; the table in the folder is then of the others."""
    from ._results import read_table

    chain: Sequence[Scene] = scene if isinstance(scene, (list, tuple)) else [scene]  # type: ignore[list-item]
    folder = Path(out) if out is not None else Path("out", f"{_stem(chain[-1])}-ensemble")
    words = _options(seeds=seeds, until=_number("until", until), jobs=jobs, out=folder)
    with ExitStack() as files:
        paths = [files.enter_context(file_of(one, named=True)) for one in chain]
        call("ensemble", *paths, *words, *settings(set), line=listener(progress))
    return read_table(folder / "ensemble.csv")


def schema() -> dict[str, Any]:
    """The JSON Schema of a whole scene: every key with its type and meaning."""
    found: dict[str, Any] = json.loads(call("schema"))
    return found

"""The programs of Bedload: where they are, how one is started, how it fails."""

from __future__ import annotations

import os
import queue
import re
import shlex
import signal
import subprocess
import sys
import threading
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Callable, NoReturn

KINDS = {
    1: "failed",
    2: "bad-input",
    3: "solver-died",
    4: "unstable",
    5: "no-room",
    6: "damaged-log",
    7: "in-use",
    101: "fault",
    130: "interrupted",
}
#: Lines of a program that an error quotes at most.
QUOTED = 200
#: How long the output of a program that has ended may stay open in a process of its own, s.
LEFT_OPEN = 2.0


class BedloadError(Exception):
    """A program of Bedload failed. `code` is its exit code, `kind` what the code means (docs/results.md),
    `message` what it said, `printed` what it had printed until then; `plan` the plan that broke a bound (of
    `check`), `out` the output folder of a run."""

    def __init__(
        self,
        code: int,
        message: str,
        *,
        printed: str = "",
        out: Path | None = None,
        plan: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(code, message)
        self.code, self.message, self.printed, self.out, self.plan = code, message, printed, out, plan

    @property
    def kind(self) -> str:
        """The meaning of the exit code: one of `failed`, `bad-input`, `solver-died`, `unstable`, `no-room`,
        `damaged-log`, `in-use`, `fault`, `interrupted`; `signal` if a signal ended the program."""
        return "signal" if self.code < 0 else KINDS.get(self.code, "failed")

    def __str__(self) -> str:
        return f"{self.message}\n({self.kind}, exit code {self.code})"


@dataclass(frozen=True)
class Progress:
    """How far a run is: at its start, every two seconds, at its end."""

    #: Simulated time and end of the run, s (`inf`: open).
    time: float
    until: float
    #: The line of the program; at the start "starts", at the end "done".
    text: str

    @property
    def part(self) -> float:
        """0 at the start, 1 at the end."""
        return min(self.time / self.until, 1.0) if self.until > 0 else 1.0


def program(name: str = "bedload") -> Path:
    """Path of a program, `bedload`, `bedload-fluid` or `bedload-dem`: in the folder that BEDLOAD_BIN names,
    else in this package, else on the PATH.

    Raises BedloadError if it is nowhere.
    """
    named = os.environ.get("BEDLOAD_BIN")
    folders = [named] if named else [str(Path(__file__).parent / "bin"), *os.get_exec_path()]
    for folder in folders:
        path = Path(folder, name)
        # The entry point of this package is a script of the same name.
        if path.is_file() and os.access(path, os.X_OK):
            with open(path, "rb") as file:
                if file.read(2) != b"#!":
                    return path.absolute()
    nowhere = (
        f"not in {named}, which BEDLOAD_BIN names" if named else "neither in this package nor on the PATH"
    )
    raise BedloadError(
        2,
        f"the program {name} is {nowhere}; remedy: install the wheel, or set BEDLOAD_BIN to the "
        "folder with the programs, such as target/release",
    )


def _parent() -> str:
    """This process as `bedload` names itself to what it starts: a run ends in order when its parent dies."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{os.getpid()} {boot}{os.readlink('/proc/self/ns/pid')}"
    except OSError:
        return ""


def _wait(process: subprocess.Popen[str]) -> None:
    """Until the program ends; a look at it twice a second."""
    while True:
        try:
            process.wait(0.5)
            return
        except subprocess.TimeoutExpired:
            continue


def _interrupt(process: subprocess.Popen[str]) -> None:
    """Ends a program in order, with checkpoint and log. One more Ctrl-C kills the solvers, a third ends the
    program, a fourth kills it."""
    for number in (signal.SIGINT, signal.SIGINT, signal.SIGINT, signal.SIGKILL):
        if process.poll() is None:
            process.send_signal(number)
        try:
            return _wait(process)
        except KeyboardInterrupt:
            continue


def call(*words: object, line: Callable[[str], object] | None = None, name: str = "bedload") -> str:
    """Runs `bedload WORDS` to its end and returns what it printed; `line` is given each line as it comes.

    Ctrl-C, or an exception of `line`, ends the program in order first. Raises BedloadError if it fails.
    """
    command = [str(program(name)), *map(str, words)]
    # A session of its own: the Ctrl-C of a terminal reaches this process alone, which passes it on once.
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
        env={**os.environ, "BEDLOAD_PARENT": _parent()},
    )
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    printed: list[str] = []
    said: deque[str] = deque(maxlen=QUOTED)

    def read(stream: IO[str], keep: Callable[[str], object]) -> None:
        for text in stream:
            keep(text)
            lines.put(text.rstrip("\n"))
        lines.put(None)

    assert process.stdout and process.stderr
    readers = [
        threading.Thread(target=read, args=pair, daemon=True)
        for pair in ((process.stdout, printed.append), (process.stderr, said.append))
    ]
    try:
        for reader in readers:
            reader.start()
        open_streams = 2
        while open_streams and not (process.poll() is not None and lines.empty()):
            try:
                text = lines.get(timeout=0.1)
            except queue.Empty:
                continue
            if text is None:
                open_streams -= 1
            elif line:
                line(text)
        _wait(process)
    except BaseException:
        _interrupt(process)
        raise
    for reader in readers:
        reader.join(LEFT_OPEN)
    while line and not lines.empty():
        if (text := lines.get()) is not None:
            line(text)
    if process.returncode:
        words_of_it = "".join(text for text in said if not _TIME.search(text)).strip()
        raise BedloadError(process.returncode, words_of_it or shlex.join(command), printed="".join(printed))
    return "".join(printed)


_TIME = re.compile(r"\bt = (\S+) of (\S+) s\b.* to go$")


def listener(progress: bool | Callable[[Progress], object] | None) -> Callable[[str], object] | None:
    """What is done with each line of a run."""
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        raise TypeError(f"progress: {progress!r}; remedy: True, False or a function of a Progress")
    if not callable(progress):
        return (lambda text: print(text, file=sys.stderr, flush=True)) if progress else None

    def tell(text: str) -> None:
        if found := _TIME.search(text):
            progress(Progress(float(found[1]), float(found[2]), text))

    return tell


def _become(name: str) -> NoReturn:
    """The entry point of a program: this process becomes it."""
    try:
        path = str(program(name))
    except BedloadError as error:
        print(f"{name}: {error.message}", file=sys.stderr)
        sys.exit(error.code)
    os.execv(path, [path, *sys.argv[1:]])


def bedload() -> NoReturn:
    """The program `bedload`."""
    _become("bedload")


def bedload_fluid() -> NoReturn:
    """The program `bedload-fluid`."""
    _become("bedload-fluid")


def bedload_dem() -> NoReturn:
    """The program `bedload-dem`."""
    _become("bedload-dem")

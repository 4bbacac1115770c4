"""The log of a run, `exchange.mcap`, read with the published package `mcap` (docs/exchange-log.md)."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._program import BedloadError


class Message(NamedTuple):
    """A message of a log."""

    #: Channel, such as `loads` (`bedload/loads` in the file) or `viewer/window`.
    topic: str
    #: Number of the window.
    step: int
    #: Of the solvers' channels the start of the window, of the viewers' its end, s.
    time: float
    #: The fields: of the solvers' channels a dictionary, of the viewers' a message of Protocol Buffers.
    head: Any
    #: A row for each grain, of `loads` and `kinematics`; else None.
    grains: NDArray[Any] | None


class _Layout:
    """What the schema of a channel says: lines of `name type words unit meaning`."""

    def __init__(self, text: str) -> None:
        parts: list[list[tuple[Any, ...]]] = [[]]
        for line in text.splitlines():
            if line == "repeat count":
                parts.append([])
            elif line and line != "end" and not line.startswith("#"):
                name, kind, words = line.split(" ")[:3]
                parts[-1].append(
                    (name, {"f64": "<f8", "u64": "<u8"}[kind], *([(int(words),)] if words != "1" else []))
                )
        self.head, *rest = [np.dtype(part) for part in parts]
        self.grain = rest[0] if rest else None

    def decode(self, data: bytes) -> tuple[dict[str, Any], NDArray[Any] | None]:
        row = np.frombuffer(data, self.head, 1)[0]
        head = {name: row[name] if row[name].ndim else row[name].item() for name in self.head.names or ()}
        if "text" in head:
            head["text"] = head["text"].tobytes().rstrip(b"\0").decode(errors="replace")
        return head, np.frombuffer(
            data, self.grain, head["count"], self.head.itemsize
        ) if self.grain else None


class Log:
    """The log of a run, and those of its resumed parts, as one."""

    def __init__(self, *paths: Path) -> None:
        try:
            import mcap.reader  # noqa: F401
        except ImportError as error:
            raise ImportError(f"{error}; remedy: pip install 'bedload[mcap]'") from error
        self.paths = paths
        with _opened(paths[0]) as reader:
            #: What stands at the beginning, text by key: `version`, `layout`, `grains`, `radii`, …
            self.manifest: dict[str, str] = {m.name: m.metadata for m in reader.iter_metadata()}["bedload"]
            #: The resolved scene (TOML).
            self.scene: str = next(
                a.data for a in reader.iter_attachments() if a.name == "scene.toml"
            ).decode()

    @property
    def topics(self) -> dict[str, int]:
        """Number of messages by topic."""
        return dict(Counter(_short(channel.topic) for _, channel, _ in self._raw(None)))

    def messages(self, *topics: str) -> Iterator[Message]:
        """The messages of these topics, or of all, in their order; one that the log has not is an error."""
        if topics and (unknown := {_short(topic) for topic in topics} - (known := self._known())):
            what = f"no topic {min(unknown)!r} in {self.paths[0]}"
            raise BedloadError(2, f"{what}; remedy: one of {', '.join(sorted(known))}")
        layouts: dict[tuple[Path, int], _Layout] = {}
        decoders: dict[tuple[Path, int], Any] = {}
        for path in self.paths:
            for schema, channel, message in self._of(path, topics):
                key, grains = (path, schema.id), None
                if channel.message_encoding == "protobuf":
                    if key not in decoders:
                        from mcap_protobuf.decoder import DecoderFactory

                        decoders[key] = DecoderFactory().decoder_for("protobuf", schema)
                    head = decoders[key](message.data)
                else:
                    if key not in layouts:
                        layouts[key] = _Layout(schema.data.decode())
                    head, grains = layouts[key].decode(message.data)
                time = head.get("header.time", head.get("time")) if isinstance(head, dict) else None
                time = 1e-9 * message.log_time if time is None else time
                yield Message(_short(channel.topic), message.sequence, time, head, grains)

    def _known(self) -> set[str]:
        """Topics that the log has, as far as its files are whole; else those that have messages."""
        known: set[str] = set()
        for path in self.paths:
            with _opened(path) as reader:
                summary = reader.get_summary()
            if summary is None:
                return set(self.topics)
            known |= {_short(channel.topic) for channel in summary.channels.values()}
        return known

    def _raw(self, topics: tuple[str, ...] | None) -> Iterator[Any]:
        for path in self.paths:
            yield from self._of(path, topics or ())

    @staticmethod
    def _of(path: Path, topics: tuple[str, ...]) -> Iterator[Any]:
        names = [name if "/" in name else f"bedload/{name}" for name in topics] or None
        with _opened(path) as reader:
            yield from reader.iter_messages(topics=names, log_time_order=False)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A reader of a log; one that breaks off is an error of ours."""
    import mcap.reader
    from mcap.exceptions import McapError
    from zstandard import ZstdError

    with open(path, "rb") as stream:
        try:
            yield mcap.reader.make_reader(stream)
        except (McapError, ZstdError, OSError, KeyError, struct.error) as error:
            what = f"{path}: the log breaks off or is damaged ({type(error).__name__}: {error})"
            remedy = "wait until the run has ended, or keep what is left: bedload log repair LOG OUT"
            raise BedloadError(6, f"{what}; remedy: {remedy}") from error


def _short(topic: str) -> str:
    return topic[len("bedload/") :] if topic.startswith("bedload/") else topic

#!/usr/bin/env python3
"""Reads every channel of a Bedload log without any Bedload code, and checks it.

    python3 -m venv venv && venv/bin/pip install -r tests/python/requirements.txt
    venv/bin/python tests/python/read_log.py exchange.mcap

Viewer channels are decoded by the published MCAP and Protocol Buffers packages; the data channels
by the decoder below, which knows nothing but the schema text in the log (see docs/exchange-log.md).
Closing line: `N passed, M failed`; exit code 1 if any failed.
"""

import math
import struct
import sys
from collections import Counter, defaultdict

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

ADVANCE, REPEAT = 1, 2


class Layout:
    """Decoder made from a schema text: lines of `name type words unit meaning`."""

    def __init__(self, text):
        self.head, self.body = [], None
        fields = self.head
        for line in text.splitlines():
            if line.startswith("#") or not line.strip():
                continue
            if line == "repeat count":
                fields = self.body = []
            elif line != "end":
                name, kind, words = line.split(" ")[:3]
                fields.append((name, {"f64": "d", "u64": "Q"}[kind], int(words)))

    @staticmethod
    def _read(fields, data, offset):
        values = {}
        for name, code, words in fields:
            found = struct.unpack_from(f"<{words}{code}", data, offset)
            values[name] = found[0] if words == 1 else found
            offset += 8 * words
        return values, offset

    def decode(self, data):
        """(values of the head, list of records); every byte must be used."""
        head, offset = self._read(self.head, data, 0)
        records = []
        for _ in range(head.get("count", 0)):
            record, offset = self._read(self.body, data, offset)
            records.append(record)
        if offset != len(data):
            raise ValueError(f"{len(data) - offset} bytes are left over")
        return head, records


class Checks:
    """Counts what holds and prints what does not."""

    def __init__(self):
        self.passed = self.failed = 0

    def that(self, holds, what):
        if holds:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED: {what}")


def numbers(values):
    """Every float in a decoded head or record."""
    for name, value in values.items():
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, float):
                yield name, number


def read(path):
    """Everything in the file: reader's summary, manifest, scene, messages in file order."""
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        manifest = {m.name: m.metadata for m in reader.iter_metadata()}.get("bedload", {})
        scenes = [a.data for a in reader.iter_attachments() if a.name == "scene.toml"]
        messages = [
            (schema, channel, message)
            for schema, channel, message in reader.iter_messages(log_time_order=False)
        ]
    return summary, manifest, scenes, messages


def check_data(messages, manifest, checks):
    """The data channels: layout, step order, counts, finite values. Returns Kinematics by step."""
    layouts, heads, grains_at = {}, defaultdict(list), {}
    for schema, channel, message in messages:
        if channel.message_encoding != "bedload-bincode":
            continue
        where = f"{channel.topic} step {message.sequence}"
        if schema.id not in layouts:
            checks.that(schema.encoding == "bedload-layout", f"{where}: schema {schema.encoding}")
            layouts[schema.id] = Layout(schema.data.decode())
        try:
            head, records = layouts[schema.id].decode(message.data)
        except (ValueError, struct.error) as error:
            checks.that(False, f"{where}: {error}")
            continue
        step = head.get("header.step", head.get("step"))
        checks.that(step == message.sequence, f"{where}: payload says step {step}")
        heads[channel.topic].append(head)
        if "count" in head:
            checks.that(head["count"] == int(manifest["grains"]), f"{where}: {head['count']} grains")
            for record in records:
                bad = [name for name, number in numbers(record) if not math.isfinite(number)]
                checks.that(not bad, f"{where}: not finite: {bad}")
        if channel.topic == "bedload/kinematics":
            grains_at[step] = (head, records)
    check_order(heads, manifest, checks)
    return grains_at


def check_order(heads, manifest, checks):
    """Windows without gap, each with its loads and kinematics."""
    expected, attempts = int(manifest["first_step"]), []
    for command in heads["bedload/command"]:
        checks.that(math.isfinite(command["time"]), "a command's time is finite")
        if command["order"] == ADVANCE:
            checks.that(command["step"] == expected, f"window {command['step']}, not {expected}")
            expected = command["step"] + 1
        if command["order"] in (ADVANCE, REPEAT):
            attempts.append((command["step"], command["attempt"]))
    checks.that(bool(attempts), "the log has windows")
    for topic, role in (("bedload/loads", "fluid"), ("bedload/kinematics", "dem")):
        found = [(head["header.step"], head["header.attempt"]) for head in heads[topic]]
        wanted = attempts if manifest[f"{role}_command"] != "[]" else []
        # The last window may have been cut short by the end of the run.
        whole = found == wanted or found == wanted[:-1]
        checks.that(whole, f"{topic}: {len(found)} messages for {len(wanted)} windows")
    for status in heads["bedload/status"]:
        checks.that(status["role"] in (0, 1), f"status of role {status['role']}")


def check_viewer(messages, grains_at, manifest, checks):
    """The viewer channels: decoded by the library, they show what the data channels say."""
    factory = DecoderFactory()
    radii = []
    for word in manifest["radii"].split():
        value, count = word.split("*")
        radii += [float(value)] * int(count)
    for schema, channel, message in messages:
        if channel.message_encoding != "protobuf":
            continue
        where = f"{channel.topic} step {message.sequence}"
        decoder = factory.decoder_for(channel.message_encoding, schema)
        frame = decoder(message.data)
        head, grains = grains_at[message.sequence]
        end = head["header.time"] + head["header.dt"]
        if schema.name == "foxglove.SceneUpdate":
            (entity,) = frame.entities
            stamp = entity.timestamp.seconds + 1e-9 * entity.timestamp.nanos
            checks.that(abs(stamp - end) <= 1e-9 + 1e-12 * end, f"{where}: stamped {stamp}")
            checks.that(len(entity.spheres) == len(grains), f"{where}: number of spheres")
            for sphere, grain, radius in zip(entity.spheres, grains, radii):
                at = sphere.pose.position
                checks.that((at.x, at.y, at.z) == grain["position"], f"{where}: position")
                checks.that(sphere.size.z == 2 * radius, f"{where}: size")
        elif schema.name == "foxglove.PointCloud":
            check_cloud(frame, grains, where, checks)
        elif schema.name == "bedload.viewer.Window":
            checks.that(frame.time == end, f"{where}: time {frame.time}")
            checks.that(frame.step == message.sequence, f"{where}: step {frame.step}")
            checks.that(frame.smallest_gap == head["header.smallest_gap"], f"{where}: gap")
        elif schema.name == "bedload.viewer.Grains":
            wanted = [grain["velocity"][2] for grain in grains][: len(frame.velocity_z)]
            checks.that(list(frame.velocity_z) == wanted, f"{where}: velocity_z")
        else:
            checks.that(False, f"{where}: unknown schema {schema.name}")


def check_cloud(cloud, grains, where, checks):
    """A point has the fields it declares, as 32-bit floats."""
    offsets = {field.name: field.offset for field in cloud.fields}
    checks.that(len(cloud.data) == cloud.point_stride * len(grains), f"{where}: size of the cloud")
    for index, grain in enumerate(grains):
        for axis, name in enumerate(("vx", "vy", "vz")):
            place = index * cloud.point_stride + offsets[name]
            (value,) = struct.unpack_from("<f", cloud.data, place)
            (wanted,) = struct.unpack("<f", struct.pack("<f", grain["velocity"][axis]))
            checks.that(value == wanted, f"{where}: {name} of grain {index}")


def main(path):
    checks = Checks()
    try:
        summary, manifest, scenes, messages = read(path)
    except Exception as error:  # every way in which a file can be unreadable
        print(f"FAILED: {path}: {error!r}")
        print("0 passed, 1 failed")
        return 1
    checks.that(summary is not None and summary.statistics is not None, "the log is complete")
    for key in ("version", "protocol", "layout", "grains", "dt", "first_step", "radii"):
        checks.that(key in manifest, f"the manifest has {key}")
    checks.that(len(scenes) == 1, "the scene is attached once")
    counts = Counter(channel.id for _, channel, _ in messages)
    if summary is not None and summary.statistics is not None:
        stated = {i: n for i, n in summary.statistics.channel_message_counts.items() if n}
        checks.that(stated == dict(counts), f"the index counts {stated}, the file has {counts}")
    times = [message.log_time for _, _, message in messages]
    checks.that(times == sorted(times), "simulated time never falls")
    grains_at = check_data(messages, manifest, checks)
    check_viewer(messages, grains_at, manifest, checks)
    names = {channel.id: channel.topic for _, channel, _ in messages}
    for channel, count in sorted(counts.items()):
        print(f"{count:8d}  {names[channel]}")
    print(f"{checks.passed} passed, {checks.failed} failed")
    return 0 if checks.failed == 0 and checks.passed > 0 else 1


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: read_log.py LOG")
    sys.exit(main(sys.argv[1]))

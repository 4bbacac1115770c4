"""Puts the three programs into the wheel, and names the platform they need."""

import os
import platform
import re
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PROGRAMS = ("bedload", "bedload-fluid", "bedload-dem")


def glibc(files):
    """The newest version of glibc whose symbols the files need: as their tables of versions name it."""
    found = {
        tuple(map(int, version))
        for file in files
        for version in re.findall(rb"\0GLIBC_(\d+)\.(\d+)(?:\.\d+)?(?=\0)", file.read_bytes())
    }
    return max(found)


class Programs(BuildHookInterface):
    """A wheel for development (`pip install -e`) has no programs: it uses those of BEDLOAD_BIN or the
    PATH."""

    def initialize(self, version, build_data):
        if version == "editable":
            return
        folder = Path(os.environ.get("BEDLOAD_BIN") or Path(self.root, "../../target/release")).resolve()
        files = [folder / program for program in PROGRAMS]
        for file in files:
            if not file.is_file():
                raise FileNotFoundError(
                    f"{file}: not there; remedy: cargo build --release, or name the folder of "
                    "the programs in BEDLOAD_BIN"
                )
        for file in files:
            build_data["force_include"][str(file)] = f"bedload/bin/{file.name}"
        for file in Path(self.root, "../..").resolve().glob("LICENSE-*"):
            build_data["force_include"][str(file)] = f"bedload/{file.name}"
        major, minor = glibc(files)
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-manylinux_{major}_{minor}_{platform.machine()}"

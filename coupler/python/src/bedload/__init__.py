"""Bedload: grains in a fluid, resolved at the scale of the grain.

    run = bedload.run("scenes/falling-sphere.toml", until=4.0)
    run.series["velocity_z[0]"], run.metrics, run.field("velocity", 2.0), run.grains(2.0)

What a scene may say is in docs/scene.md, what a run leaves in docs/results.md, this package in
docs/python.md."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._commands import check, ensemble, replay, run, schema, study
from ._program import BedloadError, Progress, program

if TYPE_CHECKING:
    from ._results import Grid, Log, Message, Run

__all__ = [
    "BedloadError",
    "Grid",
    "Log",
    "Message",
    "Progress",
    "Run",
    "check",
    "ensemble",
    "program",
    "replay",
    "run",
    "schema",
    "study",
]


def __getattr__(name: str) -> Any:
    # NumPy is loaded with the results only: the programs start without it.
    if name in __all__:
        from . import _results

        return getattr(_results, name)
    raise AttributeError(f"module 'bedload' has no attribute {name!r}")

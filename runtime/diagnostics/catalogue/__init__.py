"""The error catalogue: every error a user can meet, one module per area, found by id.

Ids of the manuals are kept. Our own are 300000 and up: language and decoder 300xxx, motion 301xxx, configuration 302xxx,
fieldbus and drives 303xxx, PLC and HLI 304xxx, runtime and system 305xxx, the running machine 306xxx, tools 307xxx,
radius compensation 309xxx, axis jobs 308xxx, recorder and replay 311xxx, single axes of a program 3125xx, the NCT dialect 32xxxx.
radius compensation 309xxx, axis jobs 308xxx, recorder and replay 311xxx, single axes of a program 3125xx, coordinate systems
315xxx.
radius compensation 309xxx, axis jobs 308xxx, recorder and replay 311xxx, single axes of a program 3125xx,
turning, threads and tapping 313xxx.
and spaces 315xxx.
measuring 314xxx.
"""

from __future__ import annotations

from types import ModuleType

from runtime.diagnostics.catalogue import (
    axes,
    axis_jobs,
    block_search,
    commissioning,
    configuration,
    control_areas,
    coordinates,
    fieldbus,
    language,
    machine,
    measuring,
    motion,
    nct,
    nct_macros,
    nct_offsets,
    offsets,
    plc,
    radius,
    recorder,
    spindle,
    system,
    technology,
    tools,
)
from runtime.diagnostics.errors import ErrorEntry

_AREAS: tuple[ModuleType, ...] = (
    language,
    motion,
    configuration,
    fieldbus,
    commissioning,
    plc,
    system,
    machine,
    technology,
    tools,
    offsets,
    nct_offsets,
    radius,
    axis_jobs,
    axes,
    block_search,
    recorder,
    nct,
    coordinates,
    nct_macros,
    spindle,
    control_areas,
    measuring,
)


def _collect() -> dict[int, ErrorEntry]:
    entries: dict[int, ErrorEntry] = {}
    for area in _AREAS:
        for value in vars(area).values():
            if isinstance(value, ErrorEntry):
                if value.id in entries and entries[value.id] is not value:
                    raise ValueError(f"error id {value.id} stands twice in the catalogue")
                entries[value.id] = value
    return entries


CATALOGUE: dict[int, ErrorEntry] = _collect()

"""Elements of many equal areas as one NumPy record array, for kernels that fill them in one go."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import numpy.typing as npt


def records(areas: ctypes.Array[Any], count: int, *elements: str) -> npt.NDArray[np.void]:
    """A view (count,) of the first `areas` with the given elements, each named by the last part of its path.

    "status.drive_state_r" becomes the field `drive_state_r`. What is written into the array is written into the areas.
    """
    structure: Any = areas._type_
    places = [_place(structure, element.split(".")) for element in elements]
    kind = np.dtype(
        {
            "names": [element.rpartition(".")[2] for element in elements],
            "formats": [np.dtype(of) for of, _ in places],
            "offsets": [offset for _, offset in places],
            "itemsize": ctypes.sizeof(structure),
        }
    )
    return np.frombuffer(memoryview(areas), dtype=kind, count=count)


def _place(structure: Any, path: list[str]) -> tuple[Any, int]:
    """Type of an element and its offset in bytes."""
    of, offset = structure, 0
    for name in path:
        offset += getattr(of, name).offset
        of = dict(field[:2] for field in of._fields_)[name]
    return of, offset

"""What all models of the description share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo


class Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def beside(value: str, info: ValidationInfo) -> str:
    """Paths in a description count from its folder, wherever the command is given."""
    folder = folder_of(info)
    return value if folder is None else str((folder / value).absolute())


def folder_of(info: ValidationInfo) -> Path | None:
    """The folder of the description that is read; None for a text without one."""
    folder = (info.context or {}).get("folder")
    return None if folder is None else Path(folder)


T = TypeVar("T")
Several = Annotated[tuple[T, ...], Field(strict=False)]  # a YAML list
FileBeside = Annotated[str, Field(min_length=1), AfterValidator(beside)]

"""Pictures that notebooks show."""

from __future__ import annotations

import os
import pathlib
from typing import Union

from ._files import write_whole


class Picture:
    """A picture as the bytes of a PNG file. Jupyter shows it."""

    def __init__(self, png: bytes) -> None:
        self._png = png

    @property
    def png(self) -> bytes:
        """The bytes of the PNG file."""
        return self._png

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the PNG file."""
        write_whole(pathlib.Path(path), self._png)

    def _repr_png_(self) -> bytes:
        return self._png

    def __repr__(self) -> str:
        return f"<fdem.Picture: {len(self._png):,} bytes>"

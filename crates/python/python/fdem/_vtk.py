"""Reads the frames of runs: VTK files whose arrays are appended, raw and compressed by zlib, as ``fdem run`` writes them.

The VTK User's Guide, "VTK File Formats", XML formats, appended data. An array is the number of its blocks, their size and that of the last one, the compressed size of each, and
the blocks.
"""

from __future__ import annotations

import pathlib
import zlib
from typing import Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

_KINDS = {"Float64": "<f8", "Float32": "<f4", "Int32": "<i4", "Int64": "<i8", "UInt64": "<u8", "UInt8": "u1"}


def read(path: pathlib.Path) -> dict[str, dict[str, npt.NDArray[Any]]]:
    """The arrays of a file by their section (``PointData``, ``CellData``, ``Points``, ``Cells``, ``Polys``, ``Lines``, ``FieldData``) and their name."""
    content = path.read_bytes()
    end = content.find(b"<AppendedData")
    start = content.find(b"_", end)
    if end < 0 or start < 0:
        raise ValueError(f"{path}: this is no frame of a run")
    try:
        root = ElementTree.fromstring(content[:end] + b"</VTKFile>")
        sections: dict[str, dict[str, npt.NDArray[Any]]] = {}
        for section in root.iter():
            for entry in section.findall("DataArray"):
                numbers = _array(content, start + 1 + int(entry.attrib["offset"]), _KINDS[entry.attrib["type"]])
                width = int(entry.attrib.get("NumberOfComponents", "1"))
                sections.setdefault(section.tag, {})[entry.attrib["Name"]] = numbers.reshape(-1, width) if width > 1 else numbers
    except (ElementTree.ParseError, KeyError, ValueError, zlib.error) as error:
        raise ValueError(f"{path}: this is no whole frame of a run: {error}") from error
    return sections


def on_grid(path: pathlib.Path, arrays: dict[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an image with an index for each axis, and the places of its points along the axes."""
    content = path.read_bytes()
    image = ElementTree.fromstring(content[: content.find(b"<AppendedData")] + b"</VTKFile>").find("ImageData")
    if image is None:
        raise ValueError(f"{path}: this is no grid")
    counts = [int(last) + 1 for last in image.attrib["WholeExtent"].split()[1::2]]
    origin, spacing = ([float(x) for x in image.attrib[name].split()] for name in ("Origin", "Spacing"))
    places = {axis: origin[k] + spacing[k] * np.arange(counts[k]) for k, axis in enumerate("xyz")}
    # The first axis is the fastest in the file.
    values = {name: array.reshape(*counts[::-1], *array.shape[1:]).swapaxes(0, 2) for name, array in arrays.items()}
    return {**places, **values}


def _array(content: bytes, at: int, kind: str) -> npt.NDArray[Any]:
    blocks = int(np.frombuffer(content, "<u8", 3, at)[0])
    sizes = np.frombuffer(content, "<u8", blocks, at + 24)
    at += 24 + 8 * blocks
    parts = []
    for size in sizes.tolist():
        parts.append(zlib.decompress(content[at : at + size]))
        at += size
    return np.frombuffer(b"".join(parts), kind)


def collection(path: pathlib.Path) -> list[tuple[float, str]]:
    """Times, s, and files of a collection (``.pvd``)."""
    try:
        root = ElementTree.fromstring(path.read_bytes())
        return [(float(entry.attrib["timestep"]), entry.attrib["file"]) for entry in root.iter("DataSet")]
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise ValueError(f"{path}: this is no collection of frames: {error}") from error

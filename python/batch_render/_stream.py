"""NPZ files that follow each other on a pipe.

An NPZ file is a ZIP archive of NPY files. Its members tell their sizes before their bytes, so that archives can be read as they
arrive. Source: PKWARE, ".ZIP File Format Specification" (APPNOTE.TXT), version 6.3.10.
"""

from __future__ import annotations

import io
import struct
import zlib
from typing import IO, Dict, Iterator

import numpy as np

_LOCAL = 0x04034B50
_CENTRAL = 0x02014B50
_END = 0x06054B50


def archives(pipe: IO[bytes]) -> Iterator[Dict[str, np.ndarray]]:
    """Reads archives until the pipe ends. One that is cut off is an ``EOFError``."""
    arrays: Dict[str, np.ndarray] = {}
    while True:
        signature = pipe.read(4)
        if not signature and not arrays:
            return
        kind = struct.unpack("<I", _whole(signature, 4))[0]
        if kind == _LOCAL:
            name, data = _member(pipe)
            arrays[name] = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
        elif kind == _CENTRAL:
            fields = struct.unpack("<6H3I5H2I", _read(pipe, 42))
            _read(pipe, fields[9] + fields[10] + fields[11])
        elif kind == _END:
            _read(pipe, struct.unpack("<4H2IH", _read(pipe, 18))[6])
            yield arrays
            arrays = {}
        else:
            raise ValueError("the pipe holds no NPZ file")


def _member(pipe: IO[bytes]) -> tuple[str, bytes]:
    """Reads the rest of a member: its name without the ending, and its bytes."""
    _, _, method, _, _, _, packed, size, name, extra = struct.unpack("<5H3I2H", _read(pipe, 26))
    path = _read(pipe, name).decode()
    _read(pipe, extra)
    data = _read(pipe, packed)
    if method == 8:
        data = zlib.decompress(data, wbits=-15)
    if len(data) != size:
        raise ValueError(f"{path} has {len(data)} bytes instead of {size}")
    return path.removesuffix(".npy"), data


def _read(pipe: IO[bytes], count: int) -> bytes:
    return _whole(pipe.read(count), count)


def _whole(data: bytes, count: int) -> bytes:
    if len(data) != count:
        raise EOFError("the last NPZ file is cut off")
    return data

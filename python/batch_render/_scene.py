"""Scenes as plain data."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np


class Scene:
    """A scene: the tables of a scene file as a ``dict``, and meshes from arrays.

    ``data`` is copied. Files that it names are relative to ``folder``.
    """

    def __init__(self, data: Mapping[str, Any], folder: Union[str, "os.PathLike[str]"] = ".") -> None:
        self.data: dict[str, Any] = _plain(data)
        self.folder = Path(folder)
        self._meshes: Optional[_Meshes] = None

    def add_mesh(
        self,
        name: str,
        vertices: Any,
        triangles: Any,
        material: str,
        *,
        normals: Any = None,
        uvs: Any = None,
        **settings: Any,
    ) -> None:
        """Adds an object of triangles.

        ``vertices`` and ``normals`` have the shape (n, 3), in m, ``uvs`` (n, 2), and ``triangles`` (m, 3), numbers of vertices from 0.
        ``settings`` are other keys of an object, such as ``group="key"`` or ``transform=[...]``.
        """
        columns = [_array(vertices, 3, "vertices")]
        names = ["x", "y", "z"]
        if normals is not None:
            columns.append(_array(normals, 3, "normals"))
            names += ["nx", "ny", "nz"]
        if uvs is not None:
            columns.append(_array(uvs, 2, "uvs"))
            names += ["s", "t"]
        count = len(columns[0])
        for column in columns:
            if len(column) != count:
                raise ValueError(f"{len(column)} normals or uvs for {count} vertices")
        faces = np.asarray(triangles)
        if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
            raise ValueError("triangles: expected integers of the shape (m, 3)")
        if not len(faces):
            raise ValueError("triangles: there are none")
        if faces.min() < 0 or faces.max() >= count:
            raise ValueError(f"triangles: a number is not one of {count} vertices")
        objects = self.data.setdefault("object", [])
        if self._meshes is None:
            self._meshes = _Meshes()
        path = self._meshes.next_file()
        _write_ply(path, names, np.hstack(columns), faces)
        objects.append({"name": name, "material": material, "shape": {"mesh": {"file": str(path)}}, **_plain(settings)})

    def toml(self) -> str:
        """Returns the scene file as text. It names the files of meshes from arrays, which exist as long as the scene or a copy does."""
        return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in self.data.items())


class _Meshes:
    """A folder of mesh files, which a scene shares with its copies. It goes with the last of them."""

    def __init__(self) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="batch-render-"))
        self._numbers = itertools.count()
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)

    def __deepcopy__(self, memo: dict[int, Any]) -> _Meshes:
        return self

    def next_file(self) -> Path:
        """Returns the path of a file that no mesh has yet."""
        return self._folder / f"{next(self._numbers)}.ply"


def _array(values: Any, width: int, what: str) -> np.ndarray:
    if np.iscomplexobj(values):
        raise ValueError(f"{what}: expected real numbers")
    array = np.asarray(values, dtype=np.float32)
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{what}: expected the shape (n, {width}), found {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what}: a number is not finite")
    return array


def _write_ply(path: Path, names: Sequence[str], vertices: np.ndarray, triangles: np.ndarray) -> None:
    properties = "".join(f"property float {name}\n" for name in names)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = triangles
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(np.ascontiguousarray(vertices, dtype="<f4").tobytes())
        file.write(faces.tobytes())


def _plain(value: Any) -> Any:
    """Copies a value as dicts, lists, texts and numbers of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def _key(key: str) -> str:
    is_bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if is_bare else _value(key)


def _value(value: Any) -> str:
    """A value in TOML, whose texts are those of JSON."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        # JSON leaves the character 127 as it is, which TOML forbids.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(inner) for inner in value) + "]"
    raise TypeError(f"a scene holds no {type(value).__name__}")

"""Rendering: the program runs, and its frames come over a pipe."""

from __future__ import annotations

import json
import logging
import os
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import IO, Any, Dict, List, Optional, Tuple, Union

import numpy as np

from ._program import RenderError, program
from ._scene import Scene
from ._stream import archives

_log = logging.getLogger("batch_render")


class Frame(Dict[str, np.ndarray]):
    """The arrays of a frame by the names of its passes; ``rgba`` is the picture."""

    #: What the files tell beside the numbers: the camera, the frame, the names of mattes.
    metadata: Dict[str, Any]

    def __init__(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().__init__((name, array) for name, array in arrays.items() if name != "metadata")
        self.metadata = json.loads(arrays["metadata"].item())

    @property
    def number(self) -> int:
        """The number of the frame or view, from 1."""
        return int(self.metadata["batch-render/frame"])


def render(
    scene: Union[str, "os.PathLike[str]", Scene, Mapping[str, Any]],
    *,
    views: Union[str, Sequence[str], None] = None,
    turntable: Optional[int] = None,
    frames: Union[str, "os.PathLike[str]", None] = None,
    values: Union[str, "os.PathLike[str]", None] = None,
    random: Union[str, "os.PathLike[str]", None] = None,
    aovs: Iterable[str] = (),
    resolution: Optional[Tuple[int, int]] = None,
    samples: Optional[int] = None,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    settings: Optional[Mapping[str, Any]] = None,
    arguments: Sequence[str] = (),
) -> Iterator[Frame]:
    """Renders a scene; the frames come in their order, each as soon as it is there.

    :param scene: a scene file, a model, a :class:`Scene`, or the tables of a scene file as a ``dict``
    :param views: views from all sides, such as ``"orbit:36@20"``, ``"hemisphere:12"`` or ``"cube"``, or several of them
    :param turntable: the frames of a turn around the scene
    :param frames: a camera path, a CSV file
    :param values: values of the scene over frames, a CSV file
    :param random: values that are drawn for each frame, a TOML file; ``metadata["batch-render/values"]`` is what was drawn, as JSON
    :param aovs: passes beside the picture, such as ``["depth", "N", "objectId"]``
    :param resolution: width and height in pixels
    :param samples: samples of a pixel
    :param seed: the seed of the random numbers
    :param threads: threads to render on; one for each processor without it
    :param settings: values of the scene by their names, such as ``{"camera.perspective.fov": 40}``
    :param arguments: other flags of the program, such as ``["--lens", "85"]``
    :raises RenderError: the program has failed
    :raises FileNotFoundError: the program is not installed
    """
    flags: List[str] = []
    for view in [views] if isinstance(views, str) else views or ():
        flags += ["--views", view]
    for name, value in [("turntable", turntable), ("samples", samples), ("seed", seed), ("threads", threads)]:
        if value is not None:
            flags += [f"--{name}", str(int(value))]
    for name, path in [("frames", frames), ("values", values), ("random", random)]:
        if path is not None:
            flags += [f"--{name}", os.path.abspath(path)]
    if resolution is not None:
        width, height = resolution
        flags += ["--resolution", f"{width}x{height}"]
    names = [aovs] if isinstance(aovs, str) else list(aovs)
    if names:
        flags += ["--aovs", ",".join(names)]
    for name, value in (settings or {}).items():
        flags += ["--set", f"{name}={_text(value)}"]
    if isinstance(scene, Mapping):
        scene = Scene(scene)
    return _frames(scene, flags + list(arguments))


def _text(value: Any) -> str:
    """The value of a setting as the program reads it."""
    from ._scene import _plain, _value

    return _value(_plain(value))


def _frames(scene: Union[str, "os.PathLike[str]", Scene], flags: List[str]) -> Iterator[Frame]:
    command = [str(program())]
    folder = None
    if isinstance(scene, Scene):
        command += ["-", "--input-format", "toml"]
        folder = scene.folder
    else:
        command.append(os.fspath(scene))
    command += [*flags, "-o", "-", "--output-format", "npz", "--progress", "none"]
    # A file takes any number of warnings; a pipe that nobody reads would fill up.
    with tempfile.TemporaryFile() as errors:
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, cwd=folder
        ) as process:
            assert process.stdin is not None and process.stdout is not None
            try:
                _send(process.stdin, scene.toml() if isinstance(scene, Scene) else "")
                try:
                    for arrays in archives(process.stdout):
                        yield Frame(arrays)
                except EOFError:
                    # The program says why.
                    pass
                code = process.wait()
            finally:
                if process.poll() is None:
                    process.terminate()
        errors.seek(0)
        _report(errors.read().decode(errors="replace"), code)


def _send(pipe: IO[bytes], text: str) -> None:
    try:
        with pipe:
            pipe.write(text.encode())
    except BrokenPipeError:
        # The program has ended before it read the scene; its exit code says why.
        pass


def _report(said: str, code: int) -> None:
    """Logs warnings and raises errors."""
    lines = said.strip().splitlines()
    if code != 0:
        text = "\n".join(lines).removeprefix("error: ") or f"the program has ended with {code}"
        raise RenderError(text, code)
    for line in lines:
        _log.warning("%s", line.removeprefix("warning: "))

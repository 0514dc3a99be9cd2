"""Rendering: the program runs, and its frames come over a pipe."""

from __future__ import annotations

import json
import logging
import operator
import os
import subprocess
import threading
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import IO, Any, Deque, Dict, List, Optional, Tuple, Union

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
        """The number of the frame, or of the view from 1."""
        return int(self.metadata["batch-render/frame"])


def render(
    scene: Union[str, "os.PathLike[str]", Scene, Mapping[str, Any]],
    *,
    views: Union[str, Sequence[str], None] = None,
    turntable: Union[int, str, None] = None,
    frames: Union[str, "os.PathLike[str]", None] = None,
    values: Union[str, "os.PathLike[str]", None] = None,
    random: Union[str, "os.PathLike[str]", None] = None,
    aovs: Iterable[str] = (),
    resolution: Union[Tuple[int, int], str, None] = None,
    samples: Optional[int] = None,
    seed: Optional[int] = None,
    threads: Optional[int] = None,
    settings: Optional[Mapping[str, Any]] = None,
    arguments: Sequence[str] = (),
) -> Iterator[Frame]:
    """Renders a scene; the frames come in their order, each as soon as it is there.

    :param scene: a scene file, a model, a :class:`Scene`, or the tables of a scene file as a ``dict``
    :param views: views from all sides, such as ``"orbit:36@20"``, ``"hemisphere:12"`` or ``"cube"``, or several of them
    :param turntable: the frames of a turn around the scene, such as ``24``, or ``"2:90"`` with the angle of all
    :param frames: a camera path, a CSV file
    :param values: values of the scene over frames, a CSV file
    :param random: values that are drawn for each frame, a TOML file; ``metadata["batch-render/values"]`` is what was drawn, as JSON
    :param aovs: passes beside the picture, such as ``["depth", "N", "objectId"]``
    :param resolution: width and height in pixels, such as ``(640, 360)``
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
    if isinstance(turntable, str):
        flags += ["--turntable", turntable]
        turntable = None
    for name, value in [("turntable", turntable), ("samples", samples), ("seed", seed), ("threads", threads)]:
        if value is not None:
            flags += [f"--{name}={operator.index(value)}"]
    for name, path in [("frames", frames), ("values", values), ("random", random)]:
        if path is not None:
            flags += [f"--{name}", os.path.abspath(path)]
    if isinstance(resolution, str):
        flags += ["--resolution", resolution]
    elif resolution is not None:
        width, height = resolution
        flags += ["--resolution", f"{width}x{height}"]
    names = [aovs] if isinstance(aovs, str) else list(aovs)
    if names:
        flags += ["--aovs", ",".join(names)]
    for name, value in (settings or {}).items():
        flags += ["--set", f"{name}={_text(value)}"]
    if isinstance(arguments, str):
        raise TypeError('arguments: expected a list of texts, such as ["--lens", "85"]')
    if isinstance(scene, Mapping):
        scene = Scene(scene)
    # The first frame may be asked for from another folder.
    folder = os.path.abspath(scene.folder if isinstance(scene, Scene) else "")
    return _frames(scene, folder, flags + list(arguments))


def _text(value: Any) -> str:
    """The value of a setting as the program reads it."""
    from ._scene import _plain, _value

    return _value(_plain(value))


def _frames(scene: Union[str, "os.PathLike[str]", Scene], folder: str, flags: List[str]) -> Iterator[Frame]:
    command = [str(program())]
    if isinstance(scene, Scene):
        command += ["-", "--input-format", "toml"]
    else:
        path = os.fspath(scene)
        # Not a flag.
        command.append(os.path.join(".", path) if path.startswith("-") else path)
    command += [*flags, "-o", "-", "--output-format", "npz", "--progress", "none"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, cwd=folder) as process:
        assert process.stdin is not None and process.stdout is not None and process.stderr is not None
        # A pipe that nobody reads would fill up.
        said: Deque[bytes] = deque()
        reader = threading.Thread(target=said.extend, args=(process.stderr,), daemon=True)
        reader.start()
        messages: List[str] = []
        try:
            _send(process.stdin, scene.toml() if isinstance(scene, Scene) else "")
            try:
                for arrays in archives(process.stdout):
                    _collect(said, messages)
                    # The rest of the last one may be on its way.
                    _log_warnings(messages, len(messages) - 1)
                    yield Frame(arrays)
            except EOFError:
                # The program says why.
                pass
            code = process.wait()
        finally:
            if process.poll() is None:
                process.terminate()
            # A program that waits until somebody reads its frames ends.
            process.stdout.close()
            reader.join()
            _collect(said, messages)
            _log_warnings(messages, len(messages))
    if code != 0:
        text = "\n".join(message.removeprefix("error: ") for message in messages)
        raise RenderError(text or f"the program has ended with {code}", code)


def _collect(said: Deque[bytes], messages: List[str]) -> None:
    """Adds the lines so far to the messages, of which each begins with its level."""
    while said:
        line = said.popleft().decode(errors="replace").rstrip()
        if line.startswith(("warning: ", "error: ")) or not messages:
            messages.append(line)
        else:
            messages[-1] += "\n" + line


def _log_warnings(messages: List[str], count: int) -> None:
    """Logs the warnings among the first messages, and takes them out."""
    for message in [message for message in messages[: max(count, 0)] if message.startswith("warning: ")]:
        messages.remove(message)
        _log.warning("%s", message.removeprefix("warning: "))


def _send(pipe: IO[bytes], text: str) -> None:
    try:
        with pipe:
            pipe.write(text.encode())
    except OSError:
        # The program has ended before it read the scene; its exit code says why. Windows calls it an invalid argument.
        pass

"""The program: where it is, and what it says when it fails."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from pathlib import Path


class RenderError(Exception):
    """The program has failed."""

    #: The exit code: 2 for wrong arguments, 65 for wrong data, 66 for missing files, 74 for errors of reading and writing.
    exit_code: int

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message)
        self.exit_code = exit_code

    def __reduce__(self) -> tuple[type[RenderError], tuple[str, int]]:
        # The error of another process comes pickled.
        return type(self), (str(self), self.exit_code)


def program() -> Path:
    """Returns the path of the program: that of the variable BATCH_RENDER, that of the wheel, or that of PATH."""
    chosen = os.environ.get("BATCH_RENDER")
    if chosen:
        return Path(chosen)
    name = "batch-render.exe" if sys.platform == "win32" else "batch-render"
    folders = [sysconfig.get_path("scripts"), str(Path(sys.executable).parent)]
    # `pip install --user` and `pip install --target` have folders of their own.
    user = sysconfig.get_preferred_scheme("user")
    folders.append(sysconfig.get_path("scripts", user))
    folders.append(str(Path(__file__).parent.parent / "bin"))
    for folder in folders:
        path = Path(folder) / name
        if path.is_file():
            return path
    found = shutil.which("batch-render")
    if found is None:
        raise FileNotFoundError("the program batch-render is not installed: name it in the variable BATCH_RENDER")
    return Path(found)

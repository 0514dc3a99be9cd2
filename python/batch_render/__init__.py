"""Renders scenes and models with the program batch-render, and gives arrays of NumPy.

>>> import batch_render
>>> for frame in batch_render.render("model.glb", views="orbit:36@20", aovs=["depth"]):
...     picture, depth = frame["rgba"], frame["depth"]
"""

from ._program import RenderError, program
from ._render import Frame, render
from ._scene import Scene

__all__ = ["Frame", "RenderError", "Scene", "program", "render"]

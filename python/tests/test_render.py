"""Frames that come over a pipe are those of files."""

import copy
import gc
import logging
import os
import pickle
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

import batch_render
from batch_render import RenderError, Scene, render

TABLES = {
    "render": {"width": 32, "height": 24, "samples": 4},
    "camera": {"perspective": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov": 30}},
    "background": {"color": [0.5, 0.5, 0.5]},
    "material": {"white": {"matte": {"albedo": [0.8, 0.8, 0.8]}}},
}
VERTICES = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def square() -> Scene:
    scene = Scene(TABLES)
    scene.add_mesh("square", VERTICES, TRIANGLES, material="white")
    return scene


def test_a_frame_is_the_npz_file(tmp_path: Path) -> None:
    scene = square()
    file = tmp_path / "scene.toml"
    file.write_text(scene.toml())
    subprocess.run(
        [batch_render.program(), file, "-o", tmp_path / "f.npz", "--aovs", "depth,objectId", "--progress", "none"],
        check=True,
        capture_output=True,
    )
    written = np.load(tmp_path / "f.npz")
    (frame,) = render(scene, aovs=["depth", "objectId"])
    assert set(frame) == set(written.files) - {"metadata"}
    for name, array in frame.items():
        assert array.dtype == written[name].dtype and np.array_equal(array, written[name]), name


def test_arrays_say_what_is_seen() -> None:
    (frame,) = render(square(), aovs=["depth", "objectId"], samples=1)
    assert frame["rgba"].shape == (24, 32, 4) and frame["rgba"].dtype == np.float32
    seen = frame["objectId"] == 1
    assert 0 < seen.sum() < seen.size
    assert np.allclose(frame["depth"][12, 16], 5, atol=1e-4)
    assert (frame["depth"][~seen] == np.float32(1e10)).all()
    assert frame.number == 1
    assert frame.metadata["resolution"] == [32, 24]


def test_frames_come_in_order_and_one_by_one() -> None:
    frames = render(square(), turntable=5, samples=1, threads=1)
    assert [frame.number for frame in frames] == [1, 2, 3, 4, 5]
    # They would take hours.
    frames = render(square(), turntable=10000, samples=1000)
    assert next(frames).number == 1
    # Whoever leaves the loop does not wait for the other frames.
    start = time.monotonic()
    frames.close()
    assert time.monotonic() - start < 30


def test_views_and_compressed_arrays() -> None:
    plain = list(render(square(), views=["orbit:3@20", "cube"], samples=1))
    assert len(plain) == 9
    packed = list(render(square(), views=["orbit:3@20", "cube"], samples=1, arguments=["--npz-compression", "deflate"]))
    assert len(packed) == len(plain)
    assert all(np.array_equal(a["rgba"], b["rgba"]) for a, b in zip(plain, packed))


def test_settings_reach_the_scene() -> None:
    (wide,) = render(square(), settings={"camera.perspective.fov": 60, "background.color": [0, 0, 1]}, aovs=["objectId"])
    (narrow,) = render(square(), aovs=["objectId"])
    assert (wide["objectId"] == 1).sum() < (narrow["objectId"] == 1).sum()
    assert np.allclose(wide["rgba"][0, 0], [0, 0, 1, 1])


def test_normals_and_uvs_are_kept() -> None:
    scene = Scene(TABLES)
    normals = np.tile([0, 0.6, 0.8], (4, 1))
    scene.add_mesh("square", VERTICES, TRIANGLES, "white", normals=normals, uvs=VERTICES[:, :2] / 2 + 0.5)
    (frame,) = render(scene, aovs=["N", "UV"], samples=1)
    assert np.allclose(frame["N"][12, 16], [0, 0.6, 0.8], atol=1e-3)
    assert np.allclose(frame["UV"][12, 16], [0.5, 0.5], atol=0.1)


def test_errors_are_those_of_the_program(tmp_path: Path) -> None:
    with pytest.raises(RenderError, match="none.glb") as missing:
        list(render(tmp_path / "none.glb"))
    assert missing.value.exit_code == 66
    with pytest.raises(RenderError, match="albdo") as wrong:
        list(render({**TABLES, "material": {"white": {"matte": {"albdo": 1}}}}))
    assert wrong.value.exit_code == 65
    with pytest.raises(RenderError) as usage:
        list(render(square(), arguments=["--no-such-flag"]))
    assert usage.value.exit_code == 2


def test_warnings_are_logged(caplog: pytest.LogCaptureFixture) -> None:
    scene = square()
    scene.data["material"]["white"] = {"matte": {"albedo": [1.5, 1, 1]}}
    with caplog.at_level(logging.WARNING, logger="batch_render"):
        list(render(scene, samples=1))
    assert any("white" in record.getMessage() for record in caplog.records)


def test_warnings_are_logged_before_the_last_frame(caplog: pytest.LogCaptureFixture) -> None:
    scene = square()
    scene.data["material"]["white"] = {"matte": {"albedo": [1.5, 1, 1]}}
    with caplog.at_level(logging.WARNING, logger="batch_render"):
        next(render(scene, turntable=100, samples=1))
    assert any("white" in record.getMessage() for record in caplog.records)


def test_errors_come_back_from_other_processes(tmp_path: Path) -> None:
    with pytest.raises(RenderError) as missing:
        list(render(tmp_path / "none.glb"))
    copy = pickle.loads(pickle.dumps(missing.value))
    assert (str(copy), copy.exit_code) == (str(missing.value), 66)


def test_files_are_found_where_render_is_called(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("-x.toml").write_text(Scene(TABLES).toml())
    frames = render("-x.toml", resolution="16x12", samples=1)
    os.chdir("/")
    assert next(frames)["rgba"].shape == (12, 16, 4)


def test_arguments_of_other_types_are_refused() -> None:
    with pytest.raises(TypeError):
        render(square(), samples=1.5)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="--lens"):
        render(square(), arguments="--lens 85")


def test_wrong_arrays_are_refused() -> None:
    scene = Scene(TABLES)
    for vertices, triangles, text in [
        (VERTICES[:, :2], TRIANGLES, "vertices"),
        (VERTICES, TRIANGLES + 2, "4 vertices"),
        (VERTICES, TRIANGLES * 1.0, "integers"),
        (VERTICES * np.nan, TRIANGLES, "finite"),
        (VERTICES * 1j, TRIANGLES, "real"),
        (VERTICES, TRIANGLES[:0], "none"),
    ]:
        with pytest.raises(ValueError, match=text):
            scene.add_mesh("wrong", vertices, triangles, "white")


def test_texts_survive_toml() -> None:
    name = 'a "b" \\ \n\t ü \u2028 \x7f \U0001f600'
    scene = Scene(TABLES)
    scene.add_mesh(name, VERTICES, TRIANGLES, "white")
    (frame,) = render(scene, aovs=["CryptoObject"], samples=1)
    assert name in frame.metadata["mattes"]["CryptoObject"]


def test_meshes_go_with_their_scene() -> None:
    scene = square()
    folder = Path(scene.data["object"][0]["shape"]["mesh"]["file"]).parent
    assert folder.is_dir()
    del scene
    assert not folder.exists()


def test_meshes_of_copies_stay_apart() -> None:
    def seen(scene: Scene) -> int:
        (frame,) = render(scene, aovs=["objectId"], samples=1)
        return int((frame["objectId"] > 0).sum())

    base = Scene(TABLES)
    large, small = copy.deepcopy(base), copy.deepcopy(base)
    base.add_mesh("square", VERTICES, TRIANGLES, material="white")
    whole = seen(base)
    large.add_mesh("card", VERTICES, TRIANGLES, material="white")
    small.add_mesh("card", VERTICES * 0.3, TRIANGLES, material="white")
    assert seen(large) == whole > 4 * seen(small)
    shared = copy.deepcopy(base)
    shared.data["object"].clear()
    shared.add_mesh("card", VERTICES * 0.3, TRIANGLES, material="white")
    assert seen(shared) == seen(small) and seen(base) == whole
    # The files of meshes stay as long as a copy needs them.
    alone = copy.copy(base)
    del base, shared
    gc.collect()
    assert seen(alone) == whole

"""Checks what a job says of itself against the JSON Schemas in docs/schema. Usage: schemas.py PROGRAM FOLDER."""

import json
import pathlib
import subprocess
import sys

import jsonschema

program, folder = sys.argv[1], pathlib.Path(sys.argv[2])


def validator(name):
    schema = json.loads(pathlib.Path("docs/schema", name).read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def job(*more, samples=4, code=0):
    """The figures and the events of a job of three frames, which ends with this code."""
    stats = folder / "stats.json"
    command = [program, "scenes/passes/scene.toml", "--turntable", "3", "--resolution", "32x18", "--samples", str(samples)]
    command += ["-o", str(folder / "schema.#.exr"), "--stats", str(stats), "--progress", "json", *more]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert done.returncode == code, done
    return json.loads(stats.read_text()), [json.loads(line) for line in done.stdout.splitlines()]


figures, events = validator("stats.json"), validator("progress.json")
seen = set()


def check(*more, **expected):
    stats, lines = job(*more, **expected)
    figures.validate(stats)
    for event in lines:
        events.validate(event)
        seen.add(event["event"])
    return stats


check("--denoise")
check()
(folder / "schema.2.exr").write_bytes(b"no picture")
(folder / "schema.3.exr").unlink()
check("--skip-existing")
stats = check("--time-limit", "0.1s", samples=1000000000)
assert all(frame["samples_per_pixel"] >= 1 for frame in stats["frames"]), stats
# A file that may not be replaced: a frame that fails.
(folder / "schema.2.exr").chmod(0o444)
check("--seed", "9", "--retries", "0", code=1)

branches = [branch["properties"]["event"] for branch in events.schema["oneOf"]]
known = {event for branch in branches for event in branch.get("enum", [branch.get("const")])}
assert seen == known, f"not seen: {known - seen}"
# The schemas refuse what they do not know.
written = {"event": "frame_written", "scene": "a.toml", "frame": 1}
assert events.is_valid(written) and events.is_valid({**written, "eye": "left"})
for wrong in [{"frame": None}, {"scene": None}, {"event": "else"}, {"eye": "middle"}, {"x": 1}]:
    assert not events.is_valid({**written, **wrong}), wrong
for key in written:
    assert not events.is_valid({known: written[known] for known in written if known != key}), key
assert not figures.is_valid({**stats, "more": 1})

# Several scenes, of which one cannot be read.
command = [program, "scenes/passes/scene.toml", "scenes/kinds/disk.toml", "none.glb", "--resolution", "32x18", "--samples", "1"]
command += ["-o", str(folder / "schema-{scene}.exr"), "--stats", str(folder / "all.json"), "--progress", "none"]
assert subprocess.run(command, stderr=subprocess.DEVNULL).returncode == 1
together = json.loads((folder / "all.json").read_text())
validator("stats-of-scenes.json").validate(together)
assert [scene["state"] for scene in together["scenes"]] == ["finished", "finished", "failed"], together
for scene in together["scenes"][:2]:
    figures.validate(scene["figures"])
print("figures and events are as their schemas say")

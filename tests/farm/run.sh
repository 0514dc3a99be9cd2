#!/bin/bash
# Runs a job, and one that denoises in a second step, by the real OpenJD command line and by a real Slurm of one node, with a frame that is broken and a task that begins again,
# and compares the frames with those of one local run. An engine that cannot be installed is left out, and a line says so.
#
# usage: run.sh PROGRAM
# OpenJD comes from PyPI; Slurm needs root and Debian's packages slurmctld, slurmd, slurm-client and munge.
set -euo pipefail
program=$(realpath "${1:?program}")
here=$(cd "$(dirname "$0")" && pwd)
home=$(mktemp -d)
stop_slurm() {
  for daemon in slurmd slurmctld munged; do
    local pid
    pid=$(cat "$home/daemons/$daemon.pid" 2> /dev/null) || continue
    kill "$pid" 2> /dev/null || continue
    for _ in $(seq 100); do
      kill -0 "$pid" 2> /dev/null || break
      sleep 0.1
    done
  done
}
trap 'stop_slurm; rm -rf "$home" || true' EXIT
failed=0

prepare() {
  mkdir -p "$home/$1" && cd "$home/$1"
  cat > s.toml <<'SCENE'
[render]
samples = 128
width = 160
height = 96
[camera]
perspective = { eye = [0, 2, 6], target = [0, 0.8, 0] }
[[light]]
point = { position = [3, 5, 4], intensity = [60, 60, 60] }
[material.gray]
matte = { albedo = 0.5 }
[[object]]
material = "gray"
shape.sphere = { center = [0, 1, 0], radius = 1 }
SCENE
}

options=(s.toml --turntable 12 -o 'f.##.exr')
denoised=("${options[@]}" --samples 8 --denoise --temporal 1)

# Compares the frames of the folder $1 with those of the local run in $2.
compare() {
  for frame in "$home/$2"/f.*.exr; do
    cmp -s "$frame" "$home/$1/$(basename "$frame")" || { echo "$1: $(basename "$frame") differs"; failed=1; return; }
  done
  echo "$1: 12 frames as by one local run"
}

# Waits until Slurm has no job left.
wait_for_slurm() {
  for _ in $(seq 600); do
    [[ -z $(squeue -h 2> /dev/null) ]] && break
    sleep 0.2
  done
}

prepare local
"$program" "${options[@]}" --progress none
prepare local-denoised
"$program" "${denoised[@]}" --progress none

if python3 -m venv "$home/venv" && "$home/venv/bin/pip" -q install openjd-cli; then
  export PATH="$home/venv/bin:$PATH"
  prepare openjd
  "$program" "${options[@]}" --range 1-4 --progress none
  truncate -s -5 f.02.exr
  "$program" submit --engine openjd --bundle job --chunk 5 --run "${options[@]}" > openjd.log 2>&1 || { tail -30 openjd.log; failed=1; }
  openjd check job/template.yaml > check.log || { cat check.log; failed=1; }
  grep -q openjd_progress openjd.log || { echo "openjd: no progress"; failed=1; }
  compare openjd local
  prepare openjd-denoised
  "$program" submit --engine openjd --bundle job --chunk 5 --run "${denoised[@]}" > openjd.log 2>&1 || { tail -30 openjd.log; failed=1; }
  compare openjd-denoised local-denoised
  prepare openjd-limits
  long="$(printf 'n%.0s' {1..150}) {a} 'b' \"c\" \$d 50% ü.toml"
  mv s.toml "$long"
  squares=$(for i in {1..300}; do echo $((i * i)); done | paste -sd,)
  "$program" submit --engine openjd --bundle job "$long" --turntable 90000 --range "$squares" -o 'f.#####.exr' > submit.log 2>&1 &&
    openjd check job/template.yaml > check.log && echo "openjd-limits: a long name and 300 scattered frames are valid" ||
    { cat submit.log check.log; failed=1; }
else
  echo "openjd: not run, it cannot be installed"
fi

packages="slurmctld slurmd slurm-client munge"
if [[ $(id -u) = 0 ]] && { command -v slurmctld > /dev/null || { apt-get update -qq && apt-get install -qq -y --no-install-recommends $packages; } > "$home/apt.log" 2>&1; } &&
  "$here/slurm-start.sh" "$home/daemons"; then
  prepare slurm
  "$program" submit --engine slurm --bundle job --chunk 5 "${options[@]}" > /dev/null
  id=$(sbatch --parsable job/frames.sbatch)
  sleep 1
  # As after the loss of a node: the task begins again.
  scontrol requeue "${id}_1" 2> /dev/null || true
  wait_for_slurm
  compare slurm local
  prepare slurm-denoised
  "$program" submit --engine slurm --bundle job --chunk 5 --run "${denoised[@]}" > /dev/null
  wait_for_slurm
  compare slurm-denoised local-denoised
else
  echo "slurm: not run, it cannot be installed or started"
fi
exit $failed

#!/usr/bin/env bash
# Runs a model with MPI on 1, 2, 3, 4 and 8 processes, kills processes, and continues with other numbers of them. Needs libopenmpi-dev, openmpi-bin and libclang-dev, or their like.
set -euo pipefail
cd "$(dirname "$0")/../../.."

# Processes may share a processor here, and containers run as root.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

# FDEM may name a program that was built with MPI.
fdem=${FDEM:-$(cargo build -p fdem --features mpi --message-format=json --quiet | sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Two blocks that collide and break.
cat >"$work/crash.toml" <<'MODEL'
[model]
title = "two blocks that collide"
end_time = 0.15e-3
gravity = "none"

[[body]]
name = "left"
material = "rock"
rectangle = { min = [0, 0], max = [0.1, 0.1] }
mesh_size = 10e-3
velocity = [40, 0]

[[body]]
name = "right"
material = "rock"
rectangle = { min = [0.101, 0.03], max = [0.201, 0.13] }
mesh_size = 10e-3
velocity = [-40, 0]

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
friction = 0.5
tensile_strength = 3e6
cohesion = 6e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20

[[history]]
name = "cracks"
crack_length = true

[output]
frames = 6
checkpoint_steps = 100
MODEL

hash_of() { sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p' "$1/run.json"; }

same() {
    test "$(hash_of "$work/one")" = "$(hash_of "$1")" || { echo "$1 has another state"; return 1; }
    cmp "$work/one/history.csv" "$1/history.csv"
    local frame
    for frame in "$work"/one/frames/*; do cmp "$frame" "$1/frames/$(basename "$frame")"; done
}

"$fdem" run "$work/crash.toml" --output "$work/one" --threads 1 --quiet
for ranks in 1 2 3 4 8; do
    for threads in 1 2; do
        timeout 300 mpirun -n "$ranks" "$fdem" run "$work/crash.toml" --output "$work/many" --threads "$threads" --quiet
        same "$work/many"
        rm -r "$work/many"
    done
done

# A rank is killed; the run continues with another number of ranks, or in one process. No two kills are at the same time of a run. KILLS=20 is a longer test.
sizes=(3 2 8 1 4)
hits=0
for round in $(seq 1 "${KILLS:-5}"); do
    timeout 300 mpirun -n "${sizes[round % 5]}" "$fdem" run "$work/crash.toml" --output "$work/killed" --threads 1 --quiet 2>/dev/null &
    launcher=$!
    for _ in $(seq 2000); do
        test -e "$work/killed/checkpoint" && break
        sleep 0.01
    done
    sleep "0.$((round * 37 % 100 + 100))"
    rank=$(pgrep -f "^$fdem run $work/crash.toml" | shuf -n 1 || true)
    if [ -n "$rank" ] && kill -KILL "$rank" 2>/dev/null; then hits=$((hits + 1)); fi
    wait "$launcher" || true
    next=${sizes[(round + 1) % 5]}
    if [ "$next" = 1 ]; then
        "$fdem" resume "$work/killed" --quiet
    else
        timeout 300 mpirun -n "$next" "$fdem" resume "$work/killed" --threads 1 --quiet
    fi
    same "$work/killed"
    rm -r "$work/killed"
done

test "$hits" -gt 0
echo "$hits runs lost a rank"

# Stages: elements vanish and appear, and the forces of what vanished are released.
cat >"$work/stages.toml" <<'MODEL'
[model]
end_time = 2e-4
[[body]]
name = "plate"
material = "rock"
rectangle = { min = [0, 0], max = [0.2, 0.2] }
mesh_size = 0.01
[[body]]
name = "block"
material = "rock"
rectangle = { min = [0.05, 0.2005], max = [0.15, 0.25] }
mesh_size = 0.01
velocity = [0, -20]
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
friction = 0.5
tensile_strength = 3e6
cohesion = 6e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20
[initial]
stress = [-2e6, -4e6, 0]
[[boundary]]
name = "around"
body = "plate"
group = "outer"
fixed = "xy"
stages = ["rest"]
[[boundary]]
name = "base"
body = "plate"
side = "bottom"
fixed = "xy"
stages = ["excavate", "impact"]
[[stage]]
name = "rest"
duration = 2e-5
[[stage]]
name = "excavate"
excavate_boxes = [[0.08, 0.08, 0.12, 0.12]]
release = 4e-5
duration = 8e-5
[[stage]]
name = "impact"
activate = ["block"]
[output]
frames = 5
MODEL
rm -r "$work/one"
"$fdem" run "$work/stages.toml" --output "$work/one" --threads 1 --quiet
for ranks in 1 2 3 8; do
    timeout 300 mpirun -n "$ranks" "$fdem" run "$work/stages.toml" --output "$work/many" --threads 1 --quiet
    same "$work/many"
    rm -r "$work/many"
done

# A model that is none: one message, exit code 2, no folder.
sed 's/density = 2700/density = -1/' "$work/crash.toml" >"$work/none.toml"
code=0
timeout 60 mpirun -n 3 "$fdem" run "$work/none.toml" --output "$work/none" --quiet 2>"$work/errors" || code=$?
test "$code" = 2
test "$(grep -c 'has 1 error' "$work/errors")" = 1
test ! -e "$work/none"

# More ranks than elements, and arguments that are none: one message each.
printf '[model]\nend_time = 1e-5\n[[body]]\nname = "a"\nmaterial = "m"\nrectangle = { min = [0, 0], max = [1, 1] }\nmesh_size = 2\n[[material]]\nname = "m"\ndensity = 2700\nyoungs_modulus = 30e9\npoissons_ratio = 0.2\n' >"$work/tiny.toml"
refused() {
    local code=0
    timeout 60 mpirun -n 8 "$fdem" "${@:2}" 2>"$work/errors" || code=$?
    test "$code" = 2
    test "$(grep -c "$1" "$work/errors")" = 1
}
refused "8 ranks are more than the 2 elements of the model" run "$work/tiny.toml" --output "$work/none" --quiet
refused "unexpected argument" run "$work/tiny.toml" --treads 3
test ! -e "$work/none"
echo "runs are the same on all numbers of ranks, and after ranks were killed"

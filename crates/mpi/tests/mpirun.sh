#!/usr/bin/env bash
# Builds with MPI, and runs the tests and the command on 1, 2, 3, 4 and 8 processes. Needs libopenmpi-dev, openmpi-bin and libclang-dev, or their like.
set -euo pipefail
cd "$(dirname "$0")/../../.."

# Processes may share a processor here, and containers run as root.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

binary() { sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1; }

# MPI_TESTS and FDEM may name programs that were built with MPI.
tests=${MPI_TESTS:-$(cargo test -p fdem-mpi --features mpi --test mpi --no-run --message-format=json --quiet | binary)}
for ranks in 1 2 3 4 8; do
    RANKS=$ranks timeout 300 mpirun -n "$ranks" "$tests"
done

fdem=${FDEM:-$(cargo build -p fdem --features mpi --message-format=json --quiet | binary)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$fdem" --version | grep -q "with MPI"
"$fdem" generate gas -n 20000 --seed 3 --neighbours 8 --output "$work/gas.npy"
count=$("$fdem" contacts "$work/gas.npy" --count --quiet)

# Compares the files of couples that any number of processes write: same FILE OPTIONS...
same() {
    local format ranks
    for format in npy csv; do
        "$fdem" contacts "$@" --output "$work/one.$format" --quiet
        test -s "$work/one.$format"
        for ranks in 2 3 4 8; do
            timeout 120 mpirun -n "$ranks" "$fdem" contacts "$@" --output "$work/many.$format" --quiet
            cmp "$work/one.$format" "$work/many.$format"
        done
    done
}

"$fdem" generate gas -n 5000 --seed 3 --sizes power:0.01:100:2.5 --output "$work/sizes.csv"
"$fdem" generate clusters -n 20000 --seed 3 --output "$work/clusters.npy"
same "$work/gas.npy"
same "$work/gas.npy" --periodic xyz --box 0,20,0,20,0,25
same "$work/gas.npy" --periodic xyz --edges 20,0,0,7,20,0,-3,5,25
same "$work/sizes.csv"
same "$work/clusters.npy"
data=../shared/data/roundrobin
if test -d "$data"; then
    same "$data/drum/PartCoordinates.txt"
    same "$data/penetration/25KParticles.txt" --skip-bad-lines
else
    echo "SKIPPED: $data is absent, so the couples of its drum and of its bed were not compared"
fi
test "$(timeout 120 mpirun -n 3 "$fdem" contacts "$work/gas.npy" --count --quiet)" = "$count"

# A failure of one rank: one message, exit code 2, no file.
"$fdem" generate gas -n 100 --output "$work/nan.npy"
printf '\xff\xff\xff\xff\xff\xff\xff\x7f' | dd of="$work/nan.npy" bs=1 seek=$(($(stat -c %s "$work/nan.npy") - 32)) conv=notrunc status=none
code=0
timeout 120 mpirun -n 3 "$fdem" contacts "$work/nan.npy" --output "$work/none.npy" --quiet 2>"$work/errors" || code=$?
test "$code" = 2
test "$(grep -c '^error:' "$work/errors")" = 1
grep -q '^error: rank 2: .*row 99' "$work/errors"
test -z "$(find "$work" -name 'none*' -o -name '.fdem*')"
echo "the command writes the same files on all numbers of ranks"

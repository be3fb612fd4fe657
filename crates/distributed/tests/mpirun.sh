#!/usr/bin/env bash
# Builds with MPI, and runs the tests and the command on 1, 2, 3, 4 and 8 processes. Needs libopenmpi-dev, openmpi-bin and libclang-dev, or their like.
set -euo pipefail
cd "$(dirname "$0")/../../.."

# Processes may share a processor here, and containers run as root.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

binary() { sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1; }

tests=$(cargo test -p fdem-distributed --features mpi --test mpi --no-run --message-format=json --quiet | binary)
for ranks in 1 2 3 4 8; do
    RANKS=$ranks timeout 300 mpirun -n "$ranks" "$tests"
done

fdem=$(cargo build -p fdem --features mpi --message-format=json --quiet | binary)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$fdem" --version | grep -q "with MPI"
"$fdem" generate gas -n 20000 --seed 3 --neighbours 8 --output "$work/gas.npy"
count=$("$fdem" contacts "$work/gas.npy" --count --quiet)
for options in "" "--periodic xyz --box 0,20,0,20,0,25"; do
    for format in npy csv; do
        # shellcheck disable=SC2086
        "$fdem" contacts "$work/gas.npy" $options --output "$work/one.$format" --quiet
        for ranks in 2 3 4 8; do
            # shellcheck disable=SC2086
            timeout 120 mpirun -n "$ranks" "$fdem" contacts "$work/gas.npy" $options --output "$work/many.$format" --quiet
            cmp "$work/one.$format" "$work/many.$format"
        done
    done
done
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

#!/usr/bin/env bash
# Builds with MPI, and runs the tests on 1, 2, 3, 4 and 8 processes.
set -euo pipefail
cd "$(dirname "$0")/../../.."

binary=$(cargo test -p fdem-distributed --features mpi --test mpi --no-run --message-format=json --quiet |
    sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)
# Processes may share a processor here, and containers run as root; both variables allow the latter.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
for ranks in 1 2 3 4 8; do
    RANKS=$ranks timeout 300 mpirun -n "$ranks" "$binary"
done

# All that CI runs.
check:
    bash .ci/run

test:
    cargo test

# All samples of the tests that sample: kills of a run, limits of memory, rounding. Minutes longer.
thorough:
    FDEM_THOROUGH=1 cargo test

# The tests under `mpirun`. Needs an MPI library and libclang: `apt install libopenmpi-dev openmpi-bin libclang-dev`.
mpi:
    bash crates/mpi/tests/mpirun.sh

# Every line of the book's ten-body example.
figures:
    cargo run -p fdem-contact --example ten_bodies

# All that needs a graphics processor of NVIDIA: kernels, examples, restarts, arrays of PyTorch and CuPy; rewrites bench/GPU.md. Fails without one.
gpu:
    bash .ci/gpu

# The book, in target/book, with its figures drawn anew. Needs `cargo install mdbook`.
book:
    cargo run -p fdem --example book_figures -- book/src/figures
    mdbook build book

# The unsafe code on few elements, under an interpreter that finds undefined behaviour. Needs `rustup +nightly component add miri rust-src`.
miri:
    cargo +nightly miri test --manifest-path crates/contact/miri/Cargo.toml --target-dir target/miri

# The Python packages side by side; needs them, and fdem, installed.
bench-python:
    python bench/python.py --write bench/PYTHON.md

# Steps of the simulation, against bounds. Minutes; other programs are added as bench/README.md says.
bench-simulation:
    cargo run --release -p fdem-bench --bin simulation -- --write bench/SIMULATION.md

# Spheres in a chute and in a tube, by turns with LAMMPS. Minutes; needs `lmp`.
bench-grains:
    cargo build --release -p fdem-bench --bin grains
    python bench/external/grains_lammps.py

# Searches on 1, 2 and 8 ranks of this machine. Needs an MPI library.
bench-distributed:
    cargo run --release -p fdem-bench --features mpi --bin distributed -- --write bench/DISTRIBUTED.md

# Steps of the flow in cracks; rewrites bench/FLUID.md.
bench-fluid:
    cargo run --release -p fdem-bench --bin fluid -- --write bench/FLUID.md

# What many ranks would hold and send, and a model of larger runs. Minutes, and 8 GB of memory.
bench-scaling:
    cargo run --release -p fdem-bench --bin scaling -- --write bench/SCALING.md

# The paper's experiments; rewrites the curves in docs/.
bench:
    cargo run --release -p fdem-bench --bin paper

# The example packing and its picture, from nothing.
example:
    cargo run --release -- generate deposit -n 600 --seed 1 --sizes lognormal:0.5:0.3 --width 30 --output examples/packing.csv
    cargo run --release -- contacts examples/packing.csv --count --picture docs/packing.svg

# Every model of examples/ at full length, in target/models.
models:
    for model in examples/*.toml; do cargo run --release -- run "$model" --force --output "target/models/$(basename "$model" .toml)" || exit 1; done

# Each fuzz target for SECONDS, under AddressSanitizer. Needs a nightly toolchain and `cargo install cargo-fuzz`.
fuzz SECONDS="60":
    cargo +nightly fuzz run rows_equals_direct -- -max_total_time={{SECONDS}} -max_len=2048 -len_control=0
    cargo +nightly fuzz run nbs_equals_direct -- -max_total_time={{SECONDS}} -max_len=2048 -len_control=0
    cargo +nightly fuzz run multilevel_equals_direct -- -max_total_time={{SECONDS}} -max_len=2048 -len_control=0
    cargo +nightly fuzz run cgrid_equals_direct -- -max_total_time={{SECONDS}} -max_len=2048 -len_control=0
    cargo +nightly fuzz run index_equals_all -- -max_total_time={{SECONDS}} -max_len=2048 -len_control=0
    cargo +nightly fuzz run read_packing -- -max_total_time={{SECONDS}} -max_len=2048 -dict=fuzz/read_packing.dict
    cargo +nightly fuzz run read_series -- -max_total_time={{SECONDS}} -max_len=4096
    cargo +nightly fuzz run read_mesh -- -max_total_time={{SECONDS}} -max_len=4096

# What a release needs, in target/downloads: static binaries, wheels, checksums. Each is installed in a bare folder and run.
dist:
    bash .ci/dist

deny:
    cargo deny check

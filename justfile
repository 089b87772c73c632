# The usual verbs; `just --list` names them.

# Render the sample folder.
samples out="out/samples":
    cargo run --release -- batch scenes/samples --out {{out}}

# Everything that CI checks, without the shared assets.
check:
    cargo fmt --all --check
    cargo clippy --release --workspace --all-targets -- -D warnings
    cargo test --release --workspace

# The tests.
test *filter:
    cargo test --release --workspace {{filter}}

# The API documentation.
doc:
    cargo doc --release --workspace --no-deps --open

# What CI runs; KILN_SHARED names the folder of shared assets and references.
ci:
    .ci/run

# Measure the claims of 2018 again: docs/seed-claims.md. Needs Pillow.
seed-claims:
    cargo build --release --bin kiln --example seed_claims
    scripts/seed_claims.py

# Measure: `just bench rays`, `sizes`, `threads`, `convergence` or `lamps`, with their options.
bench what="rays" *options:
    just bench-{{what}} {{options}}

# Rays a second against Embree's on meshes of our own, by turns in one run (Debian: apt-get install libembree-dev).
bench-rays *options:
    c++ -O3 -march=native scripts/bench/embree_rays.cpp -o target/embree_rays -lembree3 -pthread
    cargo run --release --example bench_rays -- --embree target/embree_rays {{options}}

# Rays and builds as meshes grow from a thousand triangles to ten million: a table, within ten minutes.
bench-sizes *options:
    cargo run --release --example bench_rays -- scan:1000 scan:10000 scan:100000 scan:1000000 scan:10000000 terrain:1000 terrain:10000 terrain:100000 terrain:1000000 terrain:10000000 --table --passes 2 --builds 2 --forms avx512,avx512-stream --sets camera,bounce,shadow {{options}}

# Rays on one thread and on two, beside Embree's on as many.
bench-threads *options:
    c++ -O3 -march=native scripts/bench/embree_rays.cpp -o target/embree_rays -lembree3 -pthread
    cargo run --release --example bench_rays -- --embree target/embree_rays --threads 1,2 --passes 3 --builds 1 --forms avx512-stream,avx512 --sets bounce,shadow scan terrain knot hair {{options}}

# CPU seconds to an error on the bench scenes, with a peer in turn (`--help`). KILN_SHARED names the folder of scenes and
# references; PYTHON a python3 with numpy and OpenEXR.
bench-convergence *options:
    cargo build --release
    ${PYTHON:-python3} scripts/bench/convergence.py {{options}}

# What ten thousand lamps cost beside a hundred: CPU seconds of one or more builds.
bench-lamps *kilns="target/release/kiln":
    cargo build --release
    ${PYTHON:-python3} scripts/bench/lamps.py {{kilns}}

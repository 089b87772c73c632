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

# Rays a second against Embree's on meshes of our own, by turns in one run (Debian: apt-get install libembree-dev): `just bench rays`.
bench what="rays" *options:
    c++ -O3 -march=native scripts/bench/embree_{{what}}.cpp -o target/embree_{{what}} -lembree3
    cargo run --release --example bench_{{what}} -- --embree target/embree_{{what}} {{options}}

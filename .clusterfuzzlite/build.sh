#!/usr/bin/env bash
# Builds the fuzz targets and their seeds for ClusterFuzzLite. `oracle_boundary` is left out: it needs CGAL.
set -euo pipefail
cd "$SRC/feeler"
targets="side sphere half_space line evaluate split read_3dm read_brep read_step queries"
for target in $targets; do
    cargo fuzz build -O "$target"
    cp "fuzz/target/x86_64-unknown-linux-gnu/release/$target" "$OUT/"
    printf '[libfuzzer]\nmax_len = 16384\n' > "$OUT/$target.options"
done
# The seeds without the compiler's instrumentation, which the environment here asks for.
env -u RUSTFLAGS -u CFLAGS -u CXXFLAGS cargo run --release --quiet --package xtask -- fuzz all --seeds "$WORK/seeds"
for target in $targets; do
    zip --quiet --junk-paths "$OUT/${target}_seed_corpus.zip" "$WORK/seeds/$target"/*
done

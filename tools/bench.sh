#!/usr/bin/env bash
# Runs the benchmarks of a build; tables and plots go to out/bench.   tools/bench.sh BUILD_DIR [--quick]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=$1
shift
out=out/bench
mkdir -p "$out"
for device in auto native; do
  "$build/bin/seaway-bench" effects --device "$device" --out "$out/$device" "$@"
done
for bench in "$build"/bin/bench_*; do
  printf '\n== %s\n' "$(basename "$bench")"
  "$bench" | tee "$out/$(basename "$bench").txt"
done

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every fuzz target for some seconds, from its corpus on and from the same seed each time.

    SEAWAY_PRESET=fuzz ./dev build fuzzers
    tests/fuzz/run.py build/fuzz [--seconds 30] [--jobs 2] [WORD ...]   only targets that hold one of the words

What it finds lies in BUILD_DIR/findings; once it is mended, the input belongs into tests/fuzz/corpus/NAME. Exit
code 0: every target ran and none found anything.
"""
import argparse
import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
INPUT_SECONDS_MAX = 60  # one input that takes longer hangs
START_SECONDS_MAX = 300  # to go through a corpus before the clock begins


def run(program, seconds, findings):
    """The target's name, what it did in one line, and its output where it failed."""
    name = program.name.removeprefix("fuzz_")
    with tempfile.TemporaryDirectory() as found:  # inputs that reach something new
        words = [program, f"-max_total_time={seconds}", f"-timeout={INPUT_SECONDS_MAX}", "-seed=1", "-print_final_stats=1",
                 f"-artifact_prefix={findings}/{name}-", found, CORPUS / name]
        try:
            done = subprocess.run(words, capture_output=True, text=True, errors="replace",
                                  timeout=seconds + INPUT_SECONDS_MAX + START_SECONDS_MAX)
        except subprocess.TimeoutExpired as late:
            return name, "did not end", str(late)
        executed = re.search(r"number_of_executed_units:\s*(\d+)", done.stderr)
        if done.returncode == 0 and executed:
            return name, f"{int(executed[1]):>10} inputs, {len(list(pathlib.Path(found).iterdir()))} reached something new", None
        return name, f"exit code {done.returncode}", done.stderr[-6000:]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=int, default=30)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("words", nargs="*")
    options = parser.parse_intermixed_args()
    programs = sorted(p for p in (options.build / "bin").glob("fuzz_*")
                      if not options.words or any(word in p.name for word in options.words))
    missing = [p.name for p in programs if not (CORPUS / p.name.removeprefix("fuzz_")).is_dir()]
    if not programs or missing:
        sys.exit(f"no fuzz targets in {options.build}/bin" if not programs else f"without a corpus: {missing}")
    findings = options.build / "findings"
    findings.mkdir(exist_ok=True)
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for name, line, output in pool.map(lambda p: run(p.resolve(), options.seconds, findings.resolve()), programs):
            print(f"fuzz: {name:<16} {line}", flush=True)
            if output is not None:
                failed += 1
                print(output, file=sys.stderr)
    if failed:
        sys.exit(f"fuzz: {failed} of {len(programs)} targets failed; inputs lie in {findings}")


if __name__ == "__main__":
    main()

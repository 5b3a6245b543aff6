#!/usr/bin/env python3
"""Fails on C++ that clang-format would write otherwise; with --write, writes it so.

Each version of clang-format has a taste of its own, so one judges: that of Debian 12. Where it is
not installed this says so and passes.
"""
import shutil
import subprocess
import sys

from source_files import ROOT, source_files

JUDGE = "clang-format-14"


def main():
    files = source_files(".h", ".hpp", ".cpp")
    if not shutil.which(JUDGE):
        print(f"format: not judged here, {JUDGE} is not installed")
        return 1 if "--write" in sys.argv else 0
    mode = ["-i"] if "--write" in sys.argv else ["--dry-run", "-Werror"]
    done = subprocess.run([JUDGE, *mode, *files], cwd=ROOT, capture_output=True, text=True)
    wrong = sorted({line.split(":")[0] for line in done.stderr.splitlines() if "clang-format-violations" in line})
    if wrong:
        print("format: ./dev format would change", *wrong, sep="\n  ", file=sys.stderr)
    elif done.returncode != 0:
        print(done.stderr, file=sys.stderr)
    else:
        print(f"format: {len(files)} files as {JUDGE} writes them")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())

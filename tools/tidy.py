#!/usr/bin/env python3
"""Lets clang-tidy look for bugs (.clang-tidy says which) in sources that are being changed.

    tools/tidy.py BUILD_DIR [FILE ...]

Without files: the .cpp files that differ from the last commit, so that whoever writes a line hears of it
at the next ./dev test. All of the project would take a quarter of an hour, and not every file has been
read yet; name files to read them. Of more than FILES_MAX only some are read, spread over the list, and
this is said. One version judges, as with the format; where it is not installed this says so and passes.
"""
import concurrent.futures
import json
import os
import pathlib
import shutil
import subprocess
import sys

from source_files import ROOT

JUDGE = "clang-tidy-14"
FILES_MAX = 24  # a minute or two of two cores


def git(*arguments):
    """Words that git says; none without git, or outside a checkout."""
    if not shutil.which("git"):
        return []
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.split() if done.returncode == 0 else []


def changed_files():
    return git("diff", "--name-only", "--diff-filter=d", "HEAD") + \
        git("ls-files", "--others", "--exclude-standard")


def judge(build, path):
    done = subprocess.run([JUDGE, "--quiet", "-p", str(build), path], cwd=ROOT, capture_output=True,
                          text=True)
    return done.returncode, done.stdout


def main():
    if not shutil.which(JUDGE):
        print(f"tidy: not judged here, {JUDGE} is not installed")
        return 0
    build = pathlib.Path(sys.argv[1]).resolve()
    compiled = {os.path.relpath(entry["file"], ROOT)
                for entry in json.loads((build / "compile_commands.json").read_text())}
    wanted = sorted(compiled & set(sys.argv[2:] or changed_files()))
    step = -(-len(wanted) // FILES_MAX) if len(sys.argv) == 2 and wanted else 1
    files = wanted[::step]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        answers = list(pool.map(lambda path: judge(build, path), files))
    failed = [text for code, text in answers if code != 0]
    print(*failed, sep="\n", file=sys.stderr, end="")
    if not failed:
        print(f"tidy: {len(files)} of {len(wanted)} changed sources, nothing suspicious")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Lets clang-tidy look for bugs (.clang-tidy says which) in sources that are being changed.

    tools/tidy.py BUILD_DIR [--all | FILE ...]

Without files, what changed_files() finds: whoever writes a line hears of it at the next ./dev test, and
so does whoever builds the commit or the branch. All of the project would take a quarter of an hour; name
files to read them. Of more than FILES_MAX only some are read, spread over the list, and this is said; with
--all (./dev tidy) every one that has changed. One version judges, as with the format; where it is not
installed this says so and passes.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from source_files import ROOT

JUDGE = "clang-tidy-14"
FILES_MAX = 8  # less than a minute of two cores
TRUNK = "origin/main"
NO_FILES = "4b825dc642cb6eb9a060e54bf8d69288fbee4904"  # git's name of a tree without files


def git(*arguments):
    """Words that git says; none without git, outside a checkout, or where it fails."""
    if not shutil.which("git"):
        return []
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.split() if done.returncode == 0 else []


def base_commit(git):
    """What the files are compared with: the commit where this branch left the trunk or, on the trunk itself,
    the one before. In a clone that has no such commit everything is new."""
    head = git("rev-parse", "HEAD")
    fork = git("merge-base", "HEAD", TRUNK)
    before = git("rev-parse", "--verify", "--quiet", "HEAD~1")
    return (fork if fork != head else None) or before or [NO_FILES]


def changed_files(git=git):
    """Paths that differ from base_commit(), committed or not. A header stands for its source, too, where it
    is read first."""
    paths = git("diff", "--name-only", "--diff-filter=d", *base_commit(git)) + \
        git("ls-files", "--others", "--exclude-standard")
    return paths + [path[:-2] + ".cpp" for path in paths if path.endswith(".h")]


def spread(files):
    """Of more than FILES_MAX some, as far apart from each other in the list."""
    return files[::-(-len(files) // FILES_MAX) or 1]


def without_precompiled(entry):
    """A line of compile_commands.json as clang understands it: GCC's precompiled headers are GCC's."""
    return {**entry, "command": re.sub(r" (-Winvalid-pch|-include \S+/cmake_pch\.hxx)(?= )", "", entry["command"])}


def each_source(entry):
    """A line of compile_commands.json for each source: tests are compiled some at a time, by a file of CMake's
    that includes them."""
    if not re.search(r"/Unity/unity_\d+_cxx\.cxx$", entry["file"]):
        return [entry]
    included = re.findall(r'^#include "(.*)"$', pathlib.Path(entry["file"]).read_text(), re.MULTILINE)
    return [{**entry, "file": path, "command": entry["command"].replace(entry["file"], path)} for path in included]


def judge(build, path):
    # Not clang's own warnings: the commands are GCC's, which warns where it compiles.
    done = subprocess.run([JUDGE, "--quiet", "--extra-arg=-w", "-p", str(build), path], cwd=ROOT,
                          capture_output=True, text=True)
    return done.returncode, done.stdout


def main():
    if not shutil.which(JUDGE):
        print(f"tidy: not judged here, {JUDGE} is not installed")
        return 0
    build = pathlib.Path(sys.argv[1]).resolve()
    database = json.loads((build / "compile_commands.json").read_text())
    entries = [source for entry in database for source in each_source(entry)]
    compiled = {os.path.relpath(entry["file"], ROOT) for entry in entries}
    named = sys.argv[2:]
    wanted = sorted(compiled & set(changed_files() if named in ([], ["--all"]) else named))
    files = wanted if named else spread(wanted)
    read_from = build / "tidy"
    read_from.mkdir(exist_ok=True)
    (read_from / "compile_commands.json").write_text(json.dumps([*map(without_precompiled, entries)]))
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        answers = list(pool.map(lambda path: judge(read_from, path), files))
    failed = [text for code, text in answers if code != 0]
    print(*failed, sep="\n", file=sys.stderr, end="")
    if not failed:
        more = "; ./dev tidy reads them all" if len(files) < len(wanted) else ""
        print(f"tidy: {len(files)} of {len(wanted)} changed sources, nothing suspicious{more}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Fails where docs/accuracy.md, its sentence in README.md or its pictures do not show the measurements in docs/accuracy.
"""
import shutil
import struct
import subprocess
import sys

from accuracy_page import DATA, MAIN, PAGE, PICTURES, README, digest, page, readme, runs
from source_files import ROOT, report


def description(path):
    """What a PNG says of itself; empty if nothing."""
    data, at = path.read_bytes(), 8
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        keyword, _, text = data[at + 8:at + 8 + size].partition(b"\0")
        if kind == b"tEXt" and keyword == b"Description":
            return text.decode("latin-1")
        at += 12 + size
    return ""


def age():
    """In words, how old the measurements are; nothing where no history is at hand."""
    if not shutil.which("git"):
        return ""
    commit = runs()[0].place["commit"]
    counted = subprocess.run(["git", "-C", str(ROOT), "rev-list", "--count", f"{commit}..HEAD"], capture_output=True, text=True, check=False)
    return f", measured {counted.stdout.strip()} commits ago" if counted.returncode == 0 else ""


def main():
    problems = [f"docs/accuracy/{name} is not there" for name in (f"{MAIN}.csv", "error_map.csv", "note.txt")
                if not (DATA / name).exists()]
    if not problems:
        problems += [f"{run.path.relative_to(ROOT)} is of {run.device}" for run in runs() if run.path.stem != run.device]
        again = "tools/accuracy_page.py writes it"
        if PAGE.read_text() != page():
            problems.append(f"docs/accuracy.md is out of date: {again}")
        if README.read_text() != readme():
            problems.append(f"README.md, the sentence of docs/accuracy.md, is out of date: {again}")
        problems += [f"docs/pictures/{path.name} is out of date: {again}" for path in sorted(PICTURES.glob("accuracy_*.png"))
                     if description(path) != f"docs/accuracy {digest()}"]
    return report(problems, "accuracy: page and pictures show what docs/accuracy holds" + ("" if problems else age()))


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Fails on what no file of this project holds: tabs, blanks at the end of a line, foreign line ends, no
line end at the end of the file, and, in code, the words of work that is not finished.
"""
import re
import sys

from source_files import ROOT, report, source_files

CODE = (".h", ".hpp", ".c", ".cpp", ".py", ".sh", ".cmake", ".glsl", ".comp", ".vert", ".frag", ".fbs",
        ".toml", "dev", "run", "CMakeLists.txt")
TEXT = (*CODE, ".md", ".json", ".txt", ".yml")
# Licences, and data as others wrote it, stay as they came.
AS_IT_CAME = ("LICENSE", "tests/data/", "tests/fuzz/corpus/")
UNFINISHED = re.compile(r"\b(?:TODO|FIXME|XXX|HACK|(?i:stub|placeholder|not implemented|for now))\b")
THIS = "tools/check_text.py"  # names them


def problems(path):
    text = (ROOT / path).read_bytes().decode("utf-8")
    if text and not text.endswith("\n"):
        yield f"{path}: no line end at the end of the file"
    for number, line in enumerate(text.split("\n"), 1):
        where = f"{path}:{number}: "
        if "\t" in line:
            yield where + "a tab"
        if "\r" in line:
            yield where + "a foreign line end"
        if line.endswith(" "):
            yield where + "a blank at the end of the line"
        if path.endswith(CODE) and path != THIS and (word := UNFINISHED.search(line)):
            yield where + f"'{word.group(0)}': unfinished work is not kept in the code"


def main():
    files = [path for path in source_files(*TEXT) if not path.startswith(AS_IT_CAME)]
    found = [problem for path in files for problem in problems(path)]
    return report(found, f"text: {len(files)} files, no tab, no stray blank, nothing unfinished")


if __name__ == "__main__":
    sys.exit(main())

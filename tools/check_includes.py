#!/usr/bin/env python3
"""Fails on an include that docs/architecture.md, "Rooms", does not allow.

The page's two tables are read here and stand nowhere else: which room may see which, and who may
include headers that are not ours. A header that is neither ours, nor the C++ standard's, nor in the
table is an error too: a new dependency is a decision.

Every file that calls an algorithm includes <algorithm>, itself or by a header of ours: libstdc++ 12 brings
it with other headers, libstdc++ 14 does not.
"""
import re
import sys

from source_files import ROOT, report, source_files

PAGE = "docs/architecture.md"
EVERYONE = ("fmt/",)
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


ALGORITHM = re.compile(r"\bstd::(?:(?:all|any|none)_of|(?:stable_|partial_|nth_)?(?:sort|element)|find(?:_if)?"
                       r"|count(?:_if)?|fill(?:_n)?|copy(?:_n)?|transform|(?:min|max|minmax)(?:_element)?|equal"
                       r"|reverse|shuffle|(?:lower|upper)_bound|unique|remove_if|for_each|clamp|rotate)\(")


def table(heading):
    """Rows of the page's table whose first column is headed so, as lists of cells."""
    lines = (ROOT / PAGE).read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {heading} |"))
    rows = []
    for line in lines[start + 2:]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def quoted(cell):
    return [name.rstrip("/") for name in re.findall(r"`([^`]+)`", cell)]


def below(path, folder):
    return path == folder or path.startswith(folder + "/")


ROOMS = {quoted(room)[0]: quoted(sees) for room, _, sees in table("room")}
# Header: who may include it; where, that is ".cpp" for sources alone, but for rooms named behind it.
OTHERS = {re.findall(r"`([^`]+)`", header)[0]: (quoted(who), quoted(where))
          for header, who, where in table("header")}


def room_of(path):
    """The room of a file or of an included path; None for what is not ours."""
    return max((room for room in ROOMS if below(path, room)), key=len, default=None)


def objection(path, header):
    """Why a file may not include a header; None where it may."""
    room, target = room_of(path), room_of(header)
    if "/" not in header and (ROOT / path).parent.joinpath(header).is_file():
        return None  # beside it, here and where both are installed
    if header.startswith("tests/"):
        return "nothing includes tests"
    if target:
        allowed = target == room or any(below(header, seen) for seen in ROOMS[room])
        return None if allowed else f"{room} does not see {target}"
    if header.startswith(EVERYONE) or not re.search(r"[./]", header):
        return None
    known = next((other for other in OTHERS if header.startswith(other)), None)
    if not known:
        return "it is in no table"
    who, where = OTHERS[known]
    if not any(below(path, room) for room in who):
        return f"{room} does not use {known}"
    if where and not path.endswith(".cpp") and not any(below(path, room) for room in where[1:]):
        return f"{known} is for .cpp files alone"
    return None


def brings(path, known={}):
    """All headers that a file of ours includes, directly or by others of ours."""
    if path not in known:
        known[path] = set()  # ends circles
        lines = (ROOT / path).read_text().splitlines() if (ROOT / path).is_file() else []
        for header in [match.group(1) for match in map(INCLUDE.match, lines) if match]:
            known[path] |= {header} | brings(header)
    return known[path]


def main():
    files = [path for path in source_files(".h", ".hpp", ".cpp") if room_of(path)]
    found = []
    for path in files:
        for number, line in enumerate((ROOT / path).read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            why = match and objection(path, match.group(1))
            if why:
                found.append(f"{path}:{number}: <{match.group(1)}>: {why} ({PAGE}, Rooms)")
    for path in source_files(".h", ".hpp", ".cpp"):
        code = re.sub(r"//.*", "", (ROOT / path).read_text())
        if (call := ALGORITHM.search(code)) and "algorithm" not in brings(path):
            found.append(f"{path}: {call.group(0)}) without <algorithm>")
    return report(found, f"includes: {len(files)} files, every include points the right way")


if __name__ == "__main__":
    sys.exit(main())

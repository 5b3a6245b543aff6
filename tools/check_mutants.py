#!/usr/bin/env python3
"""Fails on a mutant of tests/mutants whose text does not stand exactly once in its file any more, or whose filter
names no test: who changes the line, or the test, changes the mutant with it. That it is killed is for `./dev mutants`.
"""
import fnmatch
import re
import sys

from source_files import ROOT, report

sys.path.insert(0, str(ROOT / "tests" / "mutants"))
from run import out_of_date, read_mutants


def tests_by_name():
    text = "".join(path.read_text() for path in sorted((ROOT / "tests").glob("**/*.cpp")))
    return {".".join(names) for names in re.findall(r"\b(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text)}


def names_no_test(mutant, tests):
    """Of filters with parameters, which the sources do not spell out, nothing is said."""
    for pattern in mutant["filter"].split("-")[0].split(":"):
        if "/" not in pattern and not fnmatch.filter(tests, pattern.rstrip("*") + "*"):
            return f"its filter {pattern} names no test"
    return None


def main():
    mutants = read_mutants([])
    tests = tests_by_name()
    stale = [f"{mutant['name']}: {why}" for mutant in mutants
             if (why := out_of_date(mutant) or names_no_test(mutant, tests))]
    return report(stale, f"mutants: {len(mutants)}, every one has its place")


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Fails on a mutant of tests/mutants whose text does not stand exactly once in its file any more: who
changes the line changes the mutant with it. That it is killed is for `./dev mutants`.
"""
import sys

from source_files import ROOT, report

sys.path.insert(0, str(ROOT / "tests" / "mutants"))
from run import out_of_date, read_mutants


def main():
    mutants = read_mutants([])
    stale = [f"{mutant['name']}: {why}" for mutant in mutants if (why := out_of_date(mutant))]
    return report(stale, f"mutants: {len(mutants)}, every one has its place")


if __name__ == "__main__":
    sys.exit(main())

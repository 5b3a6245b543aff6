#!/usr/bin/env python3
"""Fails where a hard case has neither a test with its id in its name nor a reason, where a test that is
named does not exist, and where docs/hard-cases.md does not say what cases and tests say. Its figures
may differ: they are of whoever ran the tests.
"""
import sys

from hard_cases_page import CASES, PAGE, ROOT, carries, cases, ids, page, tests_by_file, tests_of
from source_files import report


def problems_of(case_id, case, files):
    tests = tests_of(case_id, case, files)
    existing = {name for names in files.values() for name in names}
    for name in tests:
        if name not in existing:
            yield f"{CASES}: {case_id} names {name}, which does not exist"
    if not any(carries(name, case_id) for name in tests) and not case.get("reason"):
        yield f"{CASES}: {case_id} has no test with its id in its name and no reason"
    for key in ("case", "naive", "here"):
        if not case.get(key):
            yield f"{CASES}: {case_id} lacks '{key}'"


def without_figures(text):
    """Lines of the page, the cells of figures left out."""
    return [" | ".join(cells[:4] + cells[5:]) if len(cells) == 6 else line
            for line in text.splitlines() for cells in [line.strip("| ").split(" | ")]]


def main():
    every, files = cases(), tests_by_file()
    problems = [f"{CASES}: {case_id} is no hard case" for case_id in every if case_id not in ids()]
    for case_id in ids():
        if case_id in every:
            problems += problems_of(case_id, every[case_id], files)
        else:
            problems.append(f"{CASES}: lacks {case_id}")
    path = ROOT / PAGE
    if not problems and (not path.exists() or without_figures(path.read_text()) != without_figures(page({}))):
        problems.append(f"{PAGE} is out of date: tools/hard_cases_page.py writes it")
    return report(problems, f"hard cases: {len(ids())}, each has its test")


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Fails where docs/effects.md does not say what the figures in docs/effects say, or the files there are not what
its generator reads.
"""
import sys

from effects_page import DATA, PAGE, SCENES, page
from source_files import report


def main():
    read = {f"{file}.csv" for file, *_ in SCENES} | {"demand.csv"}
    problems = [f"docs/effects/{path.name}: nothing reads it" for path in DATA.glob("*.csv") if path.name not in read]
    problems += [f"docs/effects/{name} is not there" for name in sorted(read) if not (DATA / name).exists()]
    if not problems and (not PAGE.exists() or PAGE.read_text() != page()):
        problems.append("docs/effects.md is out of date: tools/effects_page.py writes it")
    return report(problems, f"effects: the page says what {len(read)} tables of figures say")


if __name__ == "__main__":
    sys.exit(main())

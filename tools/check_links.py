#!/usr/bin/env python3
"""Fails on a link of a page to a file, or to a heading of a page, that is not there."""
import functools
import os.path
import re
import sys

from source_files import ROOT, report, source_files

LINK = re.compile(r"\]\(([^)\s]+)\)")


@functools.cache
def headings(path):
    """As GitHub names them."""
    titles = re.findall(r"^#+ (.*)$", (ROOT / path).read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def problems(page):
    for target in LINK.findall((ROOT / page).read_text()):
        if "://" in target:
            continue
        path, _, heading = target.partition("#")
        found = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not (ROOT / found).exists():
            yield f"{page}: {target}: there is no such file"
        elif heading and found.endswith(".md") and heading not in headings(found):
            yield f"{page}: {target}: there is no such heading"


def main():
    pages = list(source_files(".md"))
    found = [problem for page in pages for problem in problems(page)]
    return report(found, f"links: {len(pages)} pages, each link leads somewhere")


if __name__ == "__main__":
    sys.exit(main())

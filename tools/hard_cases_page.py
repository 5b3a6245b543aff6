#!/usr/bin/env python3
"""Writes docs/hard-cases.md from tests/hard_cases/cases.toml and the figures of a run:

    build/dev/tests/hard_cases/test_hard_cases --gtest_output=json:figures.json
    tools/hard_cases_page.py figures.json
"""
import argparse
import json
import math
import pathlib
import re
import sys
import tomllib

from source_files import ROOT, source_files

PAGE = "docs/hard-cases.md"
CASES = "tests/hard_cases/cases.toml"
HERE = "tests/hard_cases/"
GROUPS = {"A": ("Spectrum and spreading", 24), "B": ("Time", 9), "C": ("Transforms and storage", 11),
          "D": ("Choppiness", 7), "E": ("Foam", 7), "F": ("Codec", 10), "G": ("Queries", 10),
          "H": ("Network", 6), "I": ("Geometry, scale, statistics", 10)}
TEST = re.compile(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\)")
HEAD = """# Hard cases
Where a sea by Fourier transform goes wrong, what naive code makes of it and what Seaway does. Where figures
stand, `tests/naive` was run beside ours on the same input: *naive* is its figure. Tests hold ours to the
bound of the case, but for those named next, and naive code to missing it. Written by `tools/hard_cases_page.py` from
`tests/hard_cases/cases.toml` and a run of `test_hard_cases`; names of tests carry the ids.

Held to less than the case asks. For what it would take: A21, 5000 sets of parameters and not 100 000; F6, 1e7 values
and not 1e9; G10, 10 000 reads and not 1e7; H6, thousands of mistakes and not a million packets, which the fuzzers
(`tests/fuzz`) and `load_mutated` send by hand; C1, at 2048 points a side, which a Vulkan device alone has, three
points of each field, to 4e-5 of its rms; C10, 10 000 maps of the native device and forty of a Vulkan one. For clocks,
which no test asserts: C8, the share of subnormal numbers and not what they cost; G9, that no wave is looked at and
not a microsecond. For what there is not: A4, tiles whose sides are odd or differ do not exist, and every square power
of two from 16 to 256 is held; C2, an oblong tile is refused, and its wave runs on a square one; E3, an infinite decay
is refused by name, and foam of the longest that a scene may have, 1e6 s, rises monotonously and outlives a calm of
1000 s. For what a sea is: B7, a narrow swell is like itself one period on, in a loop or not (0.67), so 0.5 holds from
two periods on; I6, land is refused by name (a depth is above 0), where the case asks for eta = 0; I1, 0.9 and 50 km
hold for slopes and for scenes of three tiles, and its row says what repeats. Because no bound is stated outside of
what is held ([0073](decisions/0073-outside-its-keyframes-a-sea-stands.md)): G4, answers there are flagged, finite and
no higher than the sea may be; H4, they are where the stream goes on again, and what they step by then is in no bound;
who has the waves steps by nothing.

The suite takes seconds. Its soak, `build/dev/bin/load_random_seas --minutes 60` (`tests/load/load_random_seas.cpp`), serves
seas by lot - gaps, loops, narrow beams, seas that fold, half a metre of water, ripples of micrometres, waves of
100 m, ill-fitting tiles - and asks at any place within 10 000 km and any time within 30 000 years, twice the same
among them; server and client are held to the direct sum. It tells how far it is and stops at the first answer without a
flag that is beyond its bound, with what shows it and the scene in a file. Not in it: changes of a running sea; A22, I7 and H5
hold them in `sea/waves/transition.h`, `SimulationChanges` and `Changes` in a server.
"""


def ids():
    return [f"{group}{n}" for group, (_, count) in GROUPS.items() for n in range(1, count + 1)]


def cases():
    return tomllib.loads((ROOT / CASES).read_text())


def tests_by_file():
    """path -> its tests, "Suite.name", in order."""
    return {path: [".".join(names) for names in TEST.findall((ROOT / path).read_text())]
            for path in source_files(".cpp") if path.startswith("tests/")}


def carries(name, case_id):
    """The id stands in the name as a word of its own, in capitals or not."""
    return case_id.lower() in re.split(r"[_.]", name.lower())


def tests_of(case_id, case, files):
    """First those of tests/hard_cases, then those that the case names."""
    own = [name for path in sorted(files) if path.startswith(HERE) for name in files[path] if carries(name, case_id)]
    return own + [name for name in case.get("tests", []) if name not in own]


def figures(path):
    """Test -> the properties that it recorded."""
    suites = json.loads(pathlib.Path(path).read_text())["testsuites"]
    tests = [(f"{suite['name']}.{test['name']}", test) for suite in suites for test in suite["testsuite"]]
    failed = [name for name, test in tests if test.get("failures") or test.get("status") != "RUN"]
    if failed:
        sys.exit(f"{path}: not of a whole and green run: {', '.join(failed)}")
    return dict(tests)


def figure(text):
    """A figure as it is read: no exponent where three digits will do."""
    value = float(text)
    if math.isnan(value):
        return "no number"
    if math.isinf(value):
        return "infinite"
    return f"{value:.0f}" if value == round(value) and abs(value) < 1e5 else text


def measured(test):
    """A cell of the table: nothing where a test recorded nothing."""
    if "figure_ours" not in test:
        return ""
    naive = f"naive {figure(test['figure_naive'])}, " if "figure_naive" in test else ""
    text = f"{test['input']}: {test['unit']}: {naive}ours **{figure(test['figure_ours'])}**"
    return text.replace("|", r"\|")


def row(case_id, case, tests, recorded):
    cells = [case_id, case["case"], case["naive"], case["here"],
             "; ".join(filter(None, (measured(recorded.get(name, {})) for name in tests))),
             ", ".join(f"`{name}`" for name in tests) or case["reason"]]
    return "| " + " | ".join(cells) + " |"


def page(recorded):
    every, files = cases(), tests_by_file()
    lines = [HEAD]
    for group, (title, _) in GROUPS.items():
        lines += [f"## {group}. {title}", "| id | case | naive code | here | measured | tests |", "|---|---|---|---|---|---|"]
        lines += [row(case_id, every[case_id], tests_of(case_id, every[case_id], files), recorded)
                  for case_id in ids() if case_id[0] == group]
        lines.append("")
    return "\n".join(lines[:-1]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figures", help="JSON of test_hard_cases")
    text = page(figures(parser.parse_args().figures))
    (ROOT / PAGE).write_text(text)


if __name__ == "__main__":
    main()

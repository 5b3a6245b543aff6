#!/usr/bin/env python3
"""Puts one plausible mistake after another into a copy of the sources and sees the tests turn red.

    ./dev mutants [WORD ...]     only mutants whose name or file holds one of the words

The mutants stand in tests/mutants/*.toml, a [[mutant]] each:
    name         a sentence: what the mistake is
    file         path of the source
    text         what stands there today, exactly once in the file
    replacement  the mistake
    test         a test program without its "test_": it must build with the mistake, and fail
    filter       which of its tests must fail (GoogleTest's filter)

A text that is not found exactly once, a mistake that does not compile and a test that is red without
it are errors: the list is then out of date. The copy and its build lie in build/mutants; the
sources themselves are not touched. Exit code 0: every mutant was killed.
"""
import pathlib
import subprocess
import sys
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
WORK = ROOT / "build" / "mutants"
COPY = WORK / "source"
BUILD = WORK / "build"
TEST_SECONDS_MAX = 300  # as ctest allows


def read_mutants(words):
    mutants = []
    for path in sorted((ROOT / "tests" / "mutants").glob("*.toml")):
        with path.open("rb") as file:
            for mutant in tomllib.load(file).get("mutant", []):
                missing = {"name", "file", "text", "replacement", "test", "filter"} - mutant.keys()
                if missing:
                    sys.exit(f"{path.name}: {mutant.get('name', '?')}: lacks {', '.join(sorted(missing))}")
                mutants.append(mutant)
    return [m for m in mutants if not words or any(w in m["name"] or w in m["file"] for w in words)]


def out_of_date(mutant):
    source = ROOT / mutant["file"]
    count = source.read_text().count(mutant["text"]) if source.exists() else 0
    return None if count == 1 else f"its text stands {count} times in {mutant['file']}"


def copy_sources():
    """Only what has changed is written, so that the build compiles only that."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout.splitlines()
    for name in listed:
        source, target = ROOT / name, COPY / name
        if not source.is_file():
            continue
        if not target.exists() or target.read_bytes() != source.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(source.read_bytes())
            target.chmod(source.stat().st_mode)
    for target in COPY.rglob("*"):
        if target.is_file() and str(target.relative_to(COPY)) not in set(listed):
            target.unlink()


def build(test):
    return subprocess.run(["cmake", "--build", BUILD, "--target", f"test_{test}"],
                          capture_output=True, text=True)


def find_program(test):
    return next(p for p in BUILD.rglob(f"test_{test}") if p.is_file())


def passes(mutant):
    try:
        return subprocess.run([find_program(mutant["test"]), f"--gtest_filter={mutant['filter']}",
                               "--gtest_brief=1", "--gtest_fail_fast"], cwd=BUILD, timeout=TEST_SECONDS_MAX,
                              capture_output=True).returncode == 0
    except subprocess.TimeoutExpired:
        return False  # a hang is red


def clean_run(mutants):
    """Errors of tests that are red, or empty, before any mistake is in."""
    errors = {}
    for test in sorted({m["test"] for m in mutants}):
        built = build(test)
        if built.returncode:
            sys.exit(f"test_{test} does not build:\n{built.stdout[-4000:]}")
    for key in sorted({(m["test"], m["filter"]) for m in mutants}):
        listed = subprocess.run([find_program(key[0]), f"--gtest_filter={key[1]}", "--gtest_list_tests"],
                                capture_output=True, text=True).stdout
        if "  " not in listed:
            errors[key] = "the filter names no test"
        elif not passes({"test": key[0], "filter": key[1]}):
            errors[key] = "the test is red without the mistake"
    return errors


def try_mutant(mutant):
    """'killed', 'SURVIVED', or why the list is out of date."""
    target = COPY / mutant["file"]
    original = target.read_text()
    target.write_text(original.replace(mutant["text"], mutant["replacement"]))
    try:
        built = build(mutant["test"])
        if built.returncode:
            return "ERROR: it does not compile"
        return "SURVIVED" if passes(mutant) else "killed"
    finally:
        target.write_text(original)


def main():
    mutants = read_mutants(sys.argv[1:])
    if not mutants:
        sys.exit("no mutant has such a name or file")
    stale = [(m, why) for m in mutants if (why := out_of_date(m))]
    copy_sources()
    subprocess.run(["cmake", "-S", COPY, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                    # Half the time to compile and link; results are the same.
                    "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1",
                    # What a mistake leaves unused is for tests to see, not for warnings.
                    "-DSEAWAY_WERROR=OFF"], check=True, capture_output=True)
    fresh = [m for m in mutants if not out_of_date(m)]
    errors = clean_run(fresh)
    results = [(m, f"ERROR: {why}") for m, why in stale]
    for mutant in fresh:
        begin = time.monotonic()
        why = errors.get((mutant["test"], mutant["filter"]))
        result = f"ERROR: {why}" if why else try_mutant(mutant)
        results.append((mutant, result))
        print(f"{result:9} {time.monotonic() - begin:5.0f} s  {mutant['file']}: {mutant['name']}", flush=True)
    killed = sum(result == "killed" for _, result in results)
    print(f"{killed} of {len(results)} mutants killed")
    for mutant, result in results:
        if result != "killed":
            print(f"{result}: {mutant['file']}: {mutant['name']}", file=sys.stderr)
    return 0 if killed == len(results) else 1


if __name__ == "__main__":
    sys.exit(main())

"""What the checks share: the files of this project - what lies in the tree, without what is built -, and how
problems are told.
"""
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
NOT_OURS = {".git", ".cache", "build", "out", "__pycache__"}


def source_files(*endings):
    """Paths below ROOT, as written in the tree, in order; all of them or those that end so."""
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in NOT_OURS]
        found += [os.path.relpath(os.path.join(folder, name), ROOT) for name in names
                  if not endings or name.endswith(endings)]
    return sorted(found)


def report(problems, well):
    """Tells problems, one a line, or that all is well; the exit code."""
    if problems:
        print(*problems, sep="\n", file=sys.stderr)
    else:
        print(well)
    return 1 if problems else 0

#!/usr/bin/env python3
"""Which files tools/tidy.py lets clang-tidy read. Git is played: these are rules, and a machine without git
tests them, too."""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import tidy


def repository(head, fork, before, differ, untracked=()):
    """A git that says this; an empty string where it would fail."""
    def git(*arguments):
        match arguments:
            case ("rev-parse", "HEAD"):
                return head.split()
            case ("merge-base", "HEAD", "origin/main"):
                return fork.split()
            case ("rev-parse", "--verify", "--quiet", "HEAD~1"):
                return before.split()
            case ("diff", "--name-only", "--diff-filter=d", base):
                return differ.get(base, [])
            case ("ls-files", "--others", "--exclude-standard"):
                return list(untracked)
        raise AssertionError(arguments)
    return git


class ChangedFiles(unittest.TestCase):
    def test_on_a_branch_are_those_since_it_left_the_trunk(self):
        git = repository("c3", "c1", "c2", {"c1": ["sea/a.cpp", "sea/b.cpp"], "c2": ["sea/b.cpp"]})
        self.assertEqual(tidy.changed_files(git), ["sea/a.cpp", "sea/b.cpp"])

    def test_where_all_is_committed_on_the_trunk_are_those_of_the_last_commit(self):
        # What builds the trunk has nothing that is not committed: to compare with HEAD would judge nothing.
        git = repository("c3", "c3", "c2", {"c2": ["sea/b.cpp"]})
        self.assertEqual(tidy.changed_files(git), ["sea/b.cpp"])

    def test_without_a_trunk_are_those_of_the_last_commit_and_what_is_not_committed(self):
        git = repository("c3", "", "c2", {"c2": ["sea/b.cpp"]}, ["sea/new.cpp"])
        self.assertEqual(tidy.changed_files(git), ["sea/b.cpp", "sea/new.cpp"])

    def test_in_a_clone_of_one_commit_are_all(self):
        git = repository("c3", "", "", {tidy.NO_FILES: ["sea/a.cpp", "sea/b.cpp"]})
        self.assertEqual(tidy.changed_files(git), ["sea/a.cpp", "sea/b.cpp"])

    def test_without_git_are_none(self):
        self.assertEqual(tidy.changed_files(lambda *arguments: []), [])

    def test_a_header_is_read_where_its_source_includes_it(self):
        git = repository("c3", "c3", "c2", {"c2": ["sea/a.h"]})
        self.assertIn("sea/a.cpp", tidy.changed_files(git))


class Spread(unittest.TestCase):
    def test_is_all_where_they_are_few(self):
        for count in range(tidy.FILES_MAX + 1):
            self.assertEqual(tidy.spread([*range(count)]), [*range(count)])

    def test_is_some_from_one_end_to_the_other_where_they_are_many(self):
        for count in range(tidy.FILES_MAX + 1, 200):
            read = tidy.spread([*range(count)])
            self.assertLessEqual(len(read), tidy.FILES_MAX)
            self.assertLess(max(after - before for before, after in zip(read, [*read[1:], count])),
                            2 * count / tidy.FILES_MAX)


class WhatIsRead(unittest.TestCase):
    """Of twenty changed sources, by the judge's calls."""

    def read(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            changed = [f"sea/{i:02}.cpp" for i in range(20)]
            entries = [{"directory": folder, "file": str(tidy.ROOT / path), "command": f"c++ -c {path}"}
                       for path in [*changed, "sea/same.cpp"]]
            (pathlib.Path(folder) / "compile_commands.json").write_text(json.dumps(entries))
            judged = []
            with mock.patch.object(tidy.shutil, "which", return_value="/usr/bin/judge"), \
                    mock.patch.object(tidy, "changed_files", return_value=changed), \
                    mock.patch.object(tidy, "judge", side_effect=lambda build, path: judged.append(path) or (0, "")), \
                    mock.patch.object(sys, "argv", ["tidy.py", folder, *arguments]), \
                    contextlib.redirect_stdout(io.StringIO()) as said:
                self.assertEqual(tidy.main(), 0)
            return sorted(judged), said.getvalue()

    def test_is_a_part_that_says_so(self):
        judged, said = self.read()
        self.assertEqual(judged, [f"sea/{i:02}.cpp" for i in range(0, 20, 3)])
        self.assertIn("7 of 20", said)
        self.assertIn("./dev tidy", said)

    def test_is_every_changed_source_where_all_are_asked_for(self):
        judged, said = self.read("--all")
        self.assertEqual(judged, [f"sea/{i:02}.cpp" for i in range(20)])
        self.assertIn("20 of 20", said)
        self.assertNotIn("./dev tidy", said)

    def test_is_what_is_named_changed_or_not(self):
        self.assertEqual(self.read("sea/same.cpp", "sea/03.cpp")[0], ["sea/03.cpp", "sea/same.cpp"])


class CompileCommands(unittest.TestCase):
    def test_name_no_precompiled_header(self):
        # clang refuses to read what GCC has precompiled; it finds the headers where they are included.
        entry = {"file": "/s/a.cpp", "command": "c++ -O1 -Winvalid-pch -include /b/cmake_pch.hxx -o a.o -c /s/a.cpp"}
        self.assertEqual(tidy.without_precompiled(entry)["command"], "c++ -O1 -o a.o -c /s/a.cpp")
        self.assertEqual(tidy.without_precompiled(entry)["file"], "/s/a.cpp")

    def test_name_each_source_of_those_that_are_compiled_together(self):
        with tempfile.TemporaryDirectory() as folder:
            together = pathlib.Path(folder) / "Unity" / "unity_0_cxx.cxx"
            together.parent.mkdir()
            together.write_text('/* generated */\n\n#include "/s/a.cpp"\n\n#include "/s/b.cpp"\n')
            entry = {"directory": "/b", "file": str(together), "command": f"c++ -O1 -o u.o -c {together}"}
            self.assertEqual(tidy.each_source(entry), [
                {"directory": "/b", "file": "/s/a.cpp", "command": "c++ -O1 -o u.o -c /s/a.cpp"},
                {"directory": "/b", "file": "/s/b.cpp", "command": "c++ -O1 -o u.o -c /s/b.cpp"}])

    def test_are_left_alone_where_a_source_is_compiled_alone(self):
        entry = {"file": "/s/a.cpp", "command": "c++ -c /s/a.cpp"}
        self.assertEqual(tidy.each_source(entry), [entry])


if __name__ == "__main__":
    unittest.main()

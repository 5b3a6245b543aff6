#!/usr/bin/env python3
"""The commands of README.md, "Use it", run as they are written, against a server on a free port; and the program of "Use it in
your program" compiles and runs as it is written against what `cmake --install` puts into a folder.

    test_readme.py BIN_DIR [BUILD_DIR]

Taken from the page: the scene and flags of the server, and every command of the second block. Only
the port, the folder of the programs and the folder that files go to are put in. Without BUILD_DIR there is no program: a
library with a sanitizer in it is for programs that have it, too.
"""
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(sys.argv.pop(1)).resolve()
BUILD = pathlib.Path(sys.argv.pop(1)).resolve() if sys.argv[1:] and os.path.isdir(sys.argv[1]) else None
sys.path += [str(ROOT / "tests/packages"), str(ROOT / "tests/support")]

from programs import PORT, use_it_in_your_program  # noqa: E402
from served import Served  # noqa: E402

FOREVER = "--watch"  # such a command goes on until it is stopped


def use_it_blocks():
    """The lines of each code block of the section."""
    section = (ROOT / "README.md").read_text().split("\n## Use it\n")[1].split("\n## ")[0]
    return [block.strip().splitlines() for block in re.findall(r"```sh\n(.*?)```", section, re.S)]


class UseIt(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        for name in ("scenes", "docs"):  # what commands name relative to a checkout
            os.symlink(ROOT / name, pathlib.Path(self.folder.name) / name)
        (serve,), self.commands = use_it_blocks()
        words = shlex.split(serve)
        self.assertEqual(words[:2], ["./dev", "serve"])
        self.assertIn(f"127.0.0.1:{PORT}", words)
        self.server = Served(BIN / "seaway-server", *(w.replace(PORT, "0") for w in words[2:]), cwd=ROOT)
        self.port = str(self.server.port)

    def tearDown(self):
        self.server.stop()
        self.folder.cleanup()

    def start(self, command):
        words = shlex.split(command.replace(PORT, self.port))
        self.assertTrue(words[0].startswith("build/dev/bin/"), command)
        return subprocess.Popen([BIN / pathlib.Path(words[0]).name, *words[1:]], cwd=self.folder.name,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def test_every_command_runs_as_it_is_written(self):
        self.assertGreaterEqual(len(self.commands), 4)
        for command in self.commands:
            with self.subTest(command):
                program = self.start(command)
                if FOREVER in command:
                    self.assertTrue(program.stdout.readline(), "says nothing")
                    program.send_signal(signal.SIGINT)
                said, complaint = program.communicate(timeout=300)
                if FOREVER not in command:
                    self.assertEqual(program.returncode, 0, said + complaint)
                for name in re.findall(r"\S+\.png", command):
                    picture = pathlib.Path(self.folder.name) / name
                    self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"), f"{name} is no picture")

    def eight_lines(self):
        program, commands = use_it_in_your_program()
        self.assertEqual(len(program.strip().splitlines()), 8)
        self.assertIn(PORT, program)
        folder = pathlib.Path(self.folder.name)
        for component in ("library", "development"):
            subprocess.run(["cmake", "--install", BUILD, "--prefix", folder / "prefix", "--component", component],
                           check=True, capture_output=True)
        library, = (folder / "prefix").rglob("libseaway.so.?")
        environment = {**os.environ, "PKG_CONFIG_PATH": str(library.parent / "pkgconfig"),
                       "LD_LIBRARY_PATH": str(library.parent)}

        def shell(command):
            done = subprocess.run(command, shell=True, cwd=folder, env=environment, text=True, capture_output=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), command)
            return done.stdout

        (folder / "height.c").write_text(program.replace(PORT, self.port))
        said = [shell(command) for command in commands]
        self.assertRegex(said[-1], r"^-?\d+\.\d\d m \n$", "a height and no complaint")
        (folder / "height.c").write_text(program.replace(PORT, "1"))
        said = [shell(command) for command in commands]
        self.assertIn("127.0.0.1:1", said[-1], "without a server it says why")

    if BUILD:
        test_eight_lines_compile_against_what_is_installed_and_print_a_height = eight_lines


def examples_of(header):
    """The code in a header's comments: indented blocks of statements, each with the first line that it has."""
    blocks, lines = [], []
    for line in (ROOT / "client" / header).read_text().splitlines() + [""]:
        if line.startswith(" *     ") or (lines and line == " *"):
            lines.append(line[7:])
        elif lines:
            blocks.append("\n".join(lines).rstrip())
            lines = []
    return [block for block in blocks if block.endswith((";", "}"))]


class HeaderExamples(unittest.TestCase):
    """What stands in the comments of the public headers compiles as it is written, as C and as C++."""
    AROUND = """
#include "client/seaway_engine.h"
#include "client/buoyancy.h"
int complain(const char* why);
void push_up(double height_m, const double* velocity_mps);
void take(const seaway_event* event);
float texels[256];
%s
int example(%s) {
%s
    return 0;
}
"""
    GIVEN = {"client": "seaway_client* client", "hull": "seaway_hull hull", "body": "seaway_body body",
             "points": "seaway_point points[8]", "answers": "seaway_answer answers[8]"}

    def test_they_compile_as_c11_and_as_cpp(self):
        found = 0
        for header in ("seaway.h", "seaway_engine.h", "buoyancy.h"):
            for block in examples_of(header):
                found += 1
                # What an example does not declare itself it is given.
                given = [words for name, words in self.GIVEN.items()
                         if re.search(rf"\b{name}\b", block) and not re.search(rf"{re.escape(words.split('[')[0])}\b\s*[=;]", block)]
                used = [name for name in self.GIVEN if any(name in words for words in given)]
                program = self.AROUND % ("int example(" + ", ".join(given) + ");", ", ".join(given),
                                         "\n".join(f"    (void){name};" for name in used) + "\n" + block)
                for language, command in (("c", "cc -std=c11"), ("c++", "c++ -std=c++20 -Wno-missing-field-initializers")):
                    done = subprocess.run([*command.split(), "-x", language, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I", ROOT, "-"],
                                          input=program, text=True, capture_output=True)
                    self.assertEqual(done.returncode, 0, f"{header}, {language}:\n{program}\n{done.stderr}")
        self.assertGreaterEqual(found, 4)


if __name__ == "__main__":
    unittest.main()

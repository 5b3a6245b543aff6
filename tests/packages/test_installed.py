#!/usr/bin/env python3
"""What `cmake --install` puts into a prefix is what others build against, and says the truth about itself.

    test_installed.py BUILD_DIR
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from programs import ROOT, use_it_in_your_program

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
PROGRAMS = ("server", "query", "ctl", "view", "inspect", "bake", "bench")
FIND_PACKAGE = """cmake_minimum_required(VERSION 3.25)
project(other LANGUAGES C)
find_package(seaway 0.1 REQUIRED)
add_executable(height height.c)
target_link_libraries(height PRIVATE seaway::seaway)
add_executable(buoy buoy.c)
target_link_libraries(buoy PRIVATE seaway::seaway)
"""


def said(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def declared_functions():
    """Of the C headers; what stands in their comments is none."""
    headers = "".join((ROOT / "client" / name).read_text() for name in ("seaway.h", "seaway_engine.h"))
    text = re.sub(r"/\*.*?\*/", "", headers, flags=re.S)
    return set(re.findall(r"\b(seaway_\w+)\s*\([^;{]*\)\s*;", text)) - set(re.findall(r"typedef[^;]*?(seaway_\w+)\)", text))


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.prefix = pathlib.Path(cls.folder.name, "somewhere_else")
        for component in ("server", "tools", "library", "development"):
            said("cmake", "--install", BUILD, "--prefix", cls.prefix, "--component", component)
        cls.library, = cls.prefix.rglob("libseaway.so.?")
        cls.work = pathlib.Path(cls.folder.name, "work")
        cls.work.mkdir()
        cls.program, _ = use_it_in_your_program()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_library_exports_what_the_list_and_the_header_say_and_nothing_else(self):
        listed = set(re.findall(r"^    (\w+);$", (ROOT / "client/libseaway.symbols").read_text(), re.M))
        names = said("nm", "-D", "--defined-only", self.library).splitlines()
        exported = {line.split()[-1].split("@")[0] for line in names if line.split()[-2] != "A"}
        self.assertEqual(exported, listed)
        self.assertEqual(declared_functions(), listed)
        self.assertIn("SONAME               libseaway.so.0\n",
                      said("objdump", "-p", self.library) + "\n")

    def test_cmake_finds_it_in_any_prefix_and_refuses_another_minor_version(self):
        (self.work / "CMakeLists.txt").write_text(FIND_PACKAGE)
        (self.work / "height.c").write_text(self.program)
        shutil.copy(ROOT / "examples/buoy.c", self.work)  # of buoyancy.h, which calls libm
        say = ["cmake", "-S", self.work, "-B", self.work / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}"]
        said(*say)
        said("cmake", "--build", self.work / "build")
        (self.work / "CMakeLists.txt").write_text(FIND_PACKAGE.replace("0.1", "0.2"))
        self.assertNotEqual(subprocess.run(say, capture_output=True).returncode, 0)

    def test_pkg_config_has_all_that_an_example_in_c_is_linked_with(self):
        command, = re.findall(r"^ \*     (cc .*)$", (ROOT / "examples/buoy.c").read_text(), re.M)
        folder, = self.prefix.rglob("pkgconfig")
        said("sh", "-c", command, cwd=shutil.copytree(ROOT / "examples", self.work / "examples"),
             env={**os.environ, "PKG_CONFIG_PATH": str(folder)})

    def test_a_32_bit_program_is_told_in_words(self):
        # Freestanding: the machine needs no 32-bit C library for it.
        told = subprocess.run(["cc", "-m32", "-ffreestanding", "-fsyntax-only", "-x", "c", f"-I{self.prefix}/include", "-"],
                              input="#include <seaway/seaway.h>\n", capture_output=True, text=True)
        self.assertNotEqual(told.returncode, 0)
        self.assertIn("is for 64 bit", told.stderr)

    def test_headers_are_c99_and_cpp17_without_this_repository(self):
        for compiler, standard, header in (("cc", "c99", "seaway.h"), ("cc", "c99", "buoyancy.h"),
                                           ("cc", "c11", "seaway_engine.h"), ("c++", "c++17", "seaway_engine.h"),
                                           ("c++", "c++17", "seaway.hpp"), ("c++", "c++17", "buoyancy.h"),
                                           *(("cc", "c99", f"buoyancy_{part}.h") for part in ("hull", "obj", "panel", "step"))):
            said(compiler, f"-std={standard}", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-x",
                 "c++" if "++" in compiler else "c", f"-I{self.prefix}/include", "-",
                 input=f"#include <seaway/{header}>\n")

    def test_every_program_names_the_versions_of_itself_the_protocol_and_the_interface(self):
        protocol = re.search(r"uint16_t version = (\d+)", (ROOT / "protocol/messages.h").read_text()).group(1)
        interface = re.search(r"SEAWAY_ABI_VERSION (\d+)", (ROOT / "client/seaway.h").read_text()).group(1)
        for name in PROGRAMS:
            self.assertRegex(said(self.prefix / f"bin/seaway-{name}", "--version"),
                             rf"^seaway-{name} \d+\.\d+\.\d+ \(protocol {protocol}, ABI {interface}\)\n$")

    def test_every_program_has_a_page_of_the_manual_with_all_that_its_help_lists(self):
        for name in PROGRAMS:
            with self.subTest(name):
                page = self.prefix / f"share/man/man1/seaway-{name}.1.gz"
                shown = subprocess.run(["man", "--warnings", "-Tutf8", "-l", page], capture_output=True, text=True,
                                       env={**os.environ, "MANWIDTH": "80", "LC_ALL": "C.UTF-8"})
                self.assertEqual((shown.returncode, shown.stderr), (0, ""))
                text = " ".join(re.sub(r".\x08|\x1b\[[\d;]*m", "", shown.stdout).split())
                help_text = said(self.prefix / f"bin/seaway-{name}", "--help")
                options = re.findall(r"^  (?:-\w,)?(--[\w-]+)", help_text, re.M)
                commands = re.findall(r"^  (\w+) ", help_text.partition("Subcommands:")[2], re.M)
                self.assertGreaterEqual(len(options), 2)
                for word in options + commands:
                    self.assertIn(word, text)
                self.assertIn(f"seaway-{name} - ", text)

    def completions(self, name, line):
        """What bash offers for the last word of a line."""
        words = re.findall(r"=|[^\s=]+", line) + ([""] if line.endswith((" ", "=")) else [])
        script = (f"source '{self.prefix}/share/bash-completion/completions/seaway-{name}'\n"
                  f"COMP_WORDS=({' '.join(repr(word) for word in words)}) COMP_CWORD={len(words) - 1}\n"
                  f"_seaway_{name}\necho \"${{COMPREPLY[@]}}\"\n")
        return said("bash", "-uc", script, cwd=ROOT).split()

    def test_bash_completes_options_their_words_commands_and_files(self):
        for name, line, expected in (
                ("query", "seaway-query --form", ["--format"]),
                ("query", "seaway-query ws://h:1 --format ", ["table", "json", "csv"]),
                ("query", "seaway-query ws://h:1 --format=j", ["json"]),
                ("query", "seaway-query ws://h:1 --timeout ", []),
                ("inspect", "seaway-inspect --format ", ["text", "json"]),
                ("inspect", "seaway-inspect scen", ["scenes"]),
                ("server", "seaway-server scenes/cal", ["scenes/calm.toml"]),
                ("server", "seaway-server --log ", ["text", "json"]),
                ("ctl", "seaway-ctl ws://h:1 se", ["set", "sessions"]),
                ("ctl", "seaway-ctl ws://h:1 set --ov", ["--over"])):
            with self.subTest(line):
                self.assertEqual(self.completions(name, line), expected)
        for name in PROGRAMS:
            offered = self.completions(name, f"seaway-{name} --")
            listed = re.findall(r"^  (?:-\w,)?(--[\w-]+)", said(self.prefix / f"bin/seaway-{name}", "--help"), re.M)
            self.assertEqual(offered, listed)

    def test_the_bench_of_the_tools_alone_measures_its_scene_from_any_folder(self):
        tools = pathlib.Path(self.folder.name, "tools_alone")
        said("cmake", "--install", BUILD, "--prefix", tools, "--component", "tools")
        bench = tools / "bin/seaway-bench"
        self.assertIn("the same with a probe", said(bench, "sample", "--points", "1", "--seconds", "0.01", cwd=self.work))
        said(bench, "device", "--device", "native", "--rounds", "1", "--sizes", "64", cwd=self.work)

    def test_the_unit_runs_what_was_installed(self):
        unit = (self.prefix / "lib/systemd/system/seaway-server.service").read_text()
        self.assertIn(f"ExecStart={self.prefix}/bin/seaway-server {self.prefix}/etc/seaway/sea.toml", unit)
        for name in ("sea.toml", "seaway-server.toml"):
            self.assertTrue((self.prefix / "etc/seaway" / name).is_file())

    def test_what_an_operator_has_changed_stays(self):
        for name in ("sea.toml", "seaway-server.toml"):
            file = self.prefix / "etc/seaway" / name
            first = file.read_text()
            try:
                file.write_text(first + "# mine\n")
                said("cmake", "--install", BUILD, "--prefix", self.prefix, "--component", "server")
                self.assertEqual(file.read_text(), first + "# mine\n")
            finally:
                file.write_text(first)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""A program that adds this repository as a subfolder inherits none of our flags, links and runs.

    check.py SOURCE_DIR WORK_DIR PROGRAM

Configures the project beside this file in WORK_DIR and reads how its one source would be compiled:
no warning of ours, no -Werror, no sanitizer, no definition but the version; C++20 and our folders are
there. Then compiles it: its code is what our own warnings refuse. PROGRAM is the same source, with the
same flags, linked with the libraries that this build has made: what it says is what Seaway promises.
"""
import json
import pathlib
import shlex
import subprocess
import sys

source, work, program = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
here = pathlib.Path(__file__).resolve().parent

subprocess.run(["cmake", "-G", "Ninja", "-S", here, "-B", work, f"-DSEAWAY_SOURCE_DIR={source}"], check=True,
               stdout=subprocess.DEVNULL)
entries = json.loads((work / "compile_commands.json").read_text())
ours = [entry for entry in entries if entry["file"] != str(here / "consumer.cpp")]
entry, = (entry for entry in entries if entry["file"] == str(here / "consumer.cpp"))
flags = shlex.split(entry["command"])

inherited = [flag for flag in flags if flag.startswith(("-W", "-f", "-O", "-g", "-m", "-D"))
             and not flag.startswith("-DSEAWAY_VERSION=") and not flag.endswith("_SHARED")]
if inherited:
    sys.exit(f"the consumer is compiled with {' '.join(inherited)}")
if "-std=gnu++20" not in flags and "-std=c++20" not in flags:
    sys.exit("the consumer is not told that our headers are C++20")
if any(entry["file"].startswith(f"{source}/tests/") for entry in ours):
    sys.exit("the consumer is made to build our tests")
if any("-Werror" in shlex.split(entry["command"]) for entry in ours):
    sys.exit("our warnings are errors in somebody else's build")
cache = (work / "CMakeCache.txt").read_text()
if "CMAKE_BUILD_TYPE:STRING=\n" not in cache:
    sys.exit("the consumer's build type was chosen for it")
target = entry["output"] if "output" in entry else flags[flags.index("-o") + 1]
subprocess.run(["cmake", "--build", work, "--target", target], check=True, stdout=subprocess.DEVNULL)

said = subprocess.run([program], capture_output=True, text=True, timeout=60)
refused = "127.0.0.1:1"
wave, client, c_client = (said.stdout.splitlines() + ["", "", ""])[:3]
if said.returncode != 0 or wave != "a crest of 1.500 m and a trough of -1.500 m" or \
        refused not in client or c_client != f"2 {client}":
    sys.exit(f"the consumer ends with {said.returncode} and says:\n{said.stdout}{said.stderr}")
print("the consumer compiles with its own flags, " + " ".join(flags[1:-4]) + ", and runs: " + wave)

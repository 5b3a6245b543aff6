#!/usr/bin/env python3
"""Fails on an include that points the wrong way (docs/architecture.md, "Rooms").

Each room lists the rooms it may see; what it may not see is an error with file and line. Third-party
headers are bound to the rooms that are allowed to know them.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

SEA = {f"sea/{room}" for room in ("basics", "spectrum", "waves", "surface", "native", "scene", "foam")}

# Longest path first decides to which room a file belongs.
MAY_SEE = {
    "base": {"base"},
    "sea/basics": {"base", "sea/basics"},
    "sea/spectrum": {"base", "sea/basics", "sea/spectrum"},
    "sea/waves": {"base", "sea/basics", "sea/spectrum", "sea/waves"},
    "sea/surface": {"base", "sea/basics", "sea/waves", "sea/surface"},
    "sea/native": {"base", "sea/basics", "sea/waves", "sea/native"},
    "sea/scene": {"base", "sea/basics", "sea/spectrum", "sea/waves", "sea/surface", "sea/scene"},
    "sea/foam": {"base", "sea/basics", "sea/waves", "sea/surface", "sea/scene", "sea/foam"},
    "gpu": {"base", "gpu"},
    "shaders": {"base", "shaders"},
    "protocol": {"base", "sea/basics", "sea/surface", "protocol"},
    "server/device": {"base", *SEA, "gpu", "shaders", "server/device"},
    "server/simulation": {"base", *SEA, "server/device", "server/simulation"},
    "server/publish": {"base", "sea/basics", "sea/surface", "protocol", "server/publish",
                       "server/host.h"},
    "server/net": {"base", "sea/basics", "sea/surface", "protocol", "server/publish", "server/net",
                   "server/host.h"},
    "server": {"base", *SEA, "gpu", "protocol", "server", "server/device", "server/simulation",
               "server/publish", "server/net"},
    "client/view": {"base", *SEA, "gpu", "shaders", "protocol", "client", "client/view"},
    "client": {"base", *SEA, "protocol", "client"},
    "tools": {"base", *SEA, "gpu", "shaders", "protocol", "server/device", "server/simulation",
              "client", "tools"},
}

# Header prefix -> rooms that may include it; a suffix ".cpp" means: not in headers.
THIRD_PARTY = {
    "toml++/": {"sea/scene/"},
    "glm/": {"sea", "client/view"},
    "volk.h": {"gpu"},
    "vulkan/": {"gpu"},
    "flatbuffers/": {"protocol"},
    "zstd.h": {"protocol"},
    "boost/": {"server/net", "client", "server"},
    "openssl/": {"server/net", "client"},
    "spdlog/": {"server", "client"},
    "nlohmann/": {"server", "tools", "client"},
    "CLI/": {"server", "tools", "client"},
    "png.h": {"client/view", "tools"},
    "OpenEXR/": {"client/view", "tools"},
    "Imf": {"client/view", "tools"},
    "GLFW/": {"client/view"},
    "fftw3.h": set(),
}
ONLY_IN_CPP = {"boost/", "openssl/", "toml++/", "zstd.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def room_of(path):
    """The room of a file or of an included path; None for what is not ours."""
    for room in sorted(MAY_SEE, key=len, reverse=True):
        if path.startswith(room + "/"):
            return room
    return None


def problems(path):
    room = room_of(path)
    for number, line in enumerate((ROOT / path).read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        header = match.group(1)
        where = f"{path}:{number}: {room} may not include <{header}>"
        if header.startswith("tests/"):
            yield where + ": nothing includes tests"
        target = room_of(header)
        if target and target not in MAY_SEE[room] and header not in MAY_SEE[room]:
            yield where
        for prefix, rooms in THIRD_PARTY.items():
            if not header.startswith(prefix):
                continue
            if not any(path.startswith(allowed) for allowed in rooms):
                yield where
            if prefix in ONLY_IN_CPP and not path.endswith(".cpp"):
                yield where + " in a header"


def main():
    files = [str(p.relative_to(ROOT)) for room in MAY_SEE for p in (ROOT / room).rglob("*")
             if p.suffix in {".h", ".hpp", ".cpp"}]
    found = [problem for path in sorted(set(files)) for problem in problems(path)]
    for problem in found:
        print(problem, file=sys.stderr)
    if found:
        return 1
    print(f"includes: {len(set(files))} files, every include points the right way")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of docs/gallery.md: sheets in docs/pictures/gallery_*.jpg (of debug views: .png).

    tools/gallery.py BUILD_DIR [SHEET ...]

Every picture is drawn from the tiles of a server that is started for its scene and stopped again. Needs
python3-matplotlib (apt install python3-matplotlib) to put pictures side by side. All of it:
some minutes on two cores.
"""
import argparse
import contextlib
import pathlib
import subprocess
import tempfile

import matplotlib.image
import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs/pictures"
GALE = "north_sea_gale"
SCENES = ["calm", "trade_wind_swell", "crossing_seas", "measured_buoy", GALE, "hurricane", "shallow_lagoon", "gerstner_toy"]

# Sheet -> pictures a row, size of one, and (scene, arguments) of each, row by row.
SHEETS = {
    "ten": (5, "480x270", [
        (GALE, "--camera 0,0,4,0,-89"), (GALE, "--camera 0,0,3000,0,-89"), (GALE, "--camera 0,0,10000,315,-12"),
        (GALE, "--camera 0,0,50,315,-4"), (GALE, "--camera 0,0,4,35,-20"), (GALE, "--time-of-day 18.3"),
        (GALE, "--time-of-day 0"), (GALE, "--time-of-day 15.5"), (GALE, "--debug roughness"),
        (GALE, "--debug jacobian --camera 0,0,12,35,-20")]),
    "scenes": (3, "480x270", [(scene, f"--camera 0,0,8,250,-5 --time-of-day {hour}") for scene in SCENES for hour in (6.6, 12, 17.7)]),
    "heights": (3, "640x360", [(GALE, f"--camera 0,0,{z},{yaw},{pitch}") for z, yaw, pitch in
                               ((2, 35, -4), (12, 35, -6), (100, 35, -15), (1000, 35, -20), (10000, 315, -12), (20000, 35, -30))]),
    "close": (2, "640x360", [(GALE, "--camera 0,0,3,80,-25 --time-of-day 12"), (GALE, "--camera 0,0,2.5,215,-3 --time-of-day 16.5"),
                             ("hurricane", "--camera 0,0,22,150,-8 --look looks/storm.toml"), ("shallow_lagoon", "--camera 0,0,2,40,-8 --time-of-day 11"),
                             (GALE, "--camera 0,0,60,35,-40 --time-of-day 12"), (GALE, "--camera 0,0,30,215,-2 --fov 12")]),
    "waters": (3, "480x270", [(GALE, f"--camera 0,0,12,300,-12 --time-of-day 12 --water {type}") for type in ("I", "3C", "9C")] +
               [("shallow_lagoon", f"--camera 0,0,5,40,-20 {how}") for how in ("--time-of-day 12", "--look looks/coral_lagoon.toml", "--time-of-day 12 --water 9C")] +
               [(GALE, "--look looks/north_sea_dawn.toml --camera 0,0,8,80,-4"), (GALE, "--look looks/tropical_noon.toml --camera 0,0,20,160,-20"),
                (GALE, "--look looks/storm.toml --camera 0,0,12,245,-4")]),
    "below": (3, "480x270", [("shallow_lagoon", "--look looks/coral_lagoon.toml --camera 0,0,-0.8,40,15"), (GALE, "--camera 0,0,-6,205,55 --time-of-day 12"),
                             ("trade_wind_swell", "--camera 0,0,-12,265,50 --time-of-day 10")]),
    "views": (1, "1920x1260", [(GALE, "--camera 0,0,12,35,-14 --quality default --debug all")]),
}


@contextlib.contextmanager
def served(programs, scene):
    server = subprocess.Popen([programs / "seaway-server", f"scenes/{scene}.toml", "--device", "native", "--listen", "127.0.0.1:0"],
                              cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        line = server.stdout.readline()
        if not line.startswith("ready "):
            raise SystemExit(f"gallery: the server does not take {scene}")
        yield line.split()[1]
    finally:
        server.terminate()
        server.wait()


def draw(programs, sheets):
    """Scene by scene, so that each is served once."""
    with tempfile.TemporaryDirectory() as folder:
        wanted = [(scene, size, arguments, f"{folder}/{name}_{i}.png") for name in sheets
                  for size, rows in [SHEETS[name][1:]] for i, (scene, arguments) in enumerate(rows)]
        for scene in dict.fromkeys(row[0] for row in wanted):
            with served(programs, scene) as url:
                for _, size, arguments, path in (row for row in wanted if row[0] == scene):
                    subprocess.run([programs / "seaway-view", url, "--offscreen", size, "--time", "100", "--out", path,
                                    *arguments.split()], check=True, stdout=subprocess.DEVNULL)
        for name in sheets:
            across, _, rows = SHEETS[name]
            pictures = [matplotlib.image.imread(f"{folder}/{name}_{i}.png")[..., :3] for i in range(len(rows))]
            lines = [numpy.hstack(pictures[i:i + across]) for i in range(0, len(pictures), across)]
            # Photographs of the sea are ten times smaller as JPEG; edges of debug views would smear.
            ending, how = ("png", {}) if name == "views" else ("jpg", {"pil_kwargs": {"quality": 85, "optimize": True}})
            matplotlib.image.imsave(PICTURES / f"gallery_{name}.{ending}", numpy.vstack(lines), **how)
            print(f"docs/pictures/gallery_{name}.{ending}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="a build folder, as build/dev")
    parser.add_argument("sheets", nargs="*", metavar="SHEET", help=", ".join(SHEETS))
    options = parser.parse_args()
    unknown = set(options.sheets) - set(SHEETS)
    if unknown:
        parser.error(f"no such sheet: {', '.join(sorted(unknown))}; there are {', '.join(SHEETS)}")
    draw(options.build.resolve() / "bin", options.sheets or list(SHEETS))


if __name__ == "__main__":
    main()

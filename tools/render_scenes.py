#!/usr/bin/env python3
"""Renders every scene of scenes/ into docs/pictures/.

    tools/render_scenes.py BUILD_DIR [SCENE ...]

Each scene is served, one frame at 60 s of sea time is drawn from its tiles, and the server is stopped.
"""
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"

# Scene -> camera (X,Y,Z,YAW,PITCH) and hour: high enough to see the longest waves, sun in view or not.
VIEWS = {
    "calm": ("0,0,2.5,250,-4", 16.5),
    "crossing_seas": ("0,0,9,200,-7", 15.5),
    "gerstner_toy": ("0,0,6,130,-8", 14.0),
    "hurricane": ("0,0,22,150,-6", 13.0),
    "measured_buoy": ("0,0,3,205,-5", 15.0),
    "north_sea_gale": ("0,0,12,285,-6", 14.5),
    "shallow_lagoon": ("0,0,2,40,-6", 11.0),
    "trade_wind_swell": ("0,0,7,255,-4", 16.5),
}


def render(bin_dir, scene):
    camera, hour = VIEWS[scene]
    server = subprocess.Popen([bin_dir / "seaway-server", f"scenes/{scene}.toml", "--listen",
                               "127.0.0.1:0"], cwd=ROOT, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
    try:
        line = server.stdout.readline()
        if not line.startswith("ready "):
            raise SystemExit(f"render_scenes: the server does not take {scene}")
        size = "960x540" if scene == "north_sea_gale" else "640x360"
        subprocess.run([bin_dir / "seaway-view", line.split()[1], "--offscreen", size, "--frames", "1",
                        "--time", "60", "--camera", camera, "--time-of-day", str(hour), "--out",
                        str(PICTURES / f"{scene}.png")], check=True, stdout=subprocess.DEVNULL)
    finally:
        server.terminate()
        server.wait()


def main():
    bin_dir = pathlib.Path(sys.argv[1]).resolve() / "bin"
    PICTURES.mkdir(parents=True, exist_ok=True)
    for scene in sys.argv[2:] or VIEWS:
        render(bin_dir, scene)
        print(f"docs/pictures/{scene}.png")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The main job on a real sea, once: serve, query, compare, render, report, stop.

    tools/demo.py BUILD_DIR

Starts the server on scenes/north_sea_gale.toml, asks for five points now and in ten seconds three
ways (the server's answer, this side's own from streamed tiles, the exact sum), renders two pictures,
and stops everything that it started. Exit code 0 only if all of it worked.
"""
import json
import pathlib
import subprocess
import sys
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "demo"
SCENE = "scenes/north_sea_gale.toml"
DEVICE = "llvmpipe"  # lavapipe, which is everywhere: the demo shows the Vulkan path, also without a GPU
POINTS = ["0,0", "12.5,-40", "250,125", "-3000,4200", "100000,-250000"]


class Server:
    """seaway-server on a free port; stopped when the block ends, whatever happens in it."""

    def __init__(self, bin_dir):
        self.bin_dir = bin_dir

    def __enter__(self):
        self.log = open(OUT / "server.log", "w")
        self.process = subprocess.Popen(
            [self.bin_dir / "seaway-server", SCENE, "--listen", "127.0.0.1:0", "--device", DEVICE], cwd=ROOT,
            stdout=subprocess.PIPE, stderr=self.log, text=True)
        line = self.process.stdout.readline()
        if not line.startswith("ready "):
            self.process.wait()
            raise SystemExit(f"demo: the server did not start; {OUT / 'server.log'} says:\n" +
                             (OUT / "server.log").read_text())
        self.url = line.split()[1]
        return self

    def __exit__(self, *unused):
        self.process.terminate()
        try:
            self.process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.log.close()

    def get(self, path):
        with urllib.request.urlopen(self.url.replace("ws://", "http://") + path, timeout=5) as reply:
            return reply.read().decode()


def query(server, *flags):
    arguments = [f"--at={point}" for point in POINTS]
    done = subprocess.run([server.bin_dir / "seaway-query", server.url, *arguments, "--format", "json",
                           *flags], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"demo: seaway-query {' '.join(flags)} failed: {done.stderr.strip()}")
    return json.loads(done.stdout)


def compare(server):
    """Prints the table; returns the largest difference of an answer from the exact sum, m."""
    now_s = query(server, "--time", "now")[0]["t_s"]
    print(f"{'x_m':>9} {'y_m':>9} {'t_s':>8} | {'server_m':>9} {'local_m':>9} {'exact_m':>9} |"
          f" {'server-exact':>12} {'local-exact':>12} {'bound_m':>8}")
    worst = 0.0
    for t_s in (now_s, now_s + 10.0):
        at = ("--time", f"{t_s:.6f}")
        rows = zip(query(server, *at), query(server, *at, "--local"), query(server, *at, "--exact"))
        for served, local, exact in rows:
            off_server = served["height_m"] - exact["height_m"]
            off_local = local["height_m"] - exact["height_m"]
            bound = max(served["error_m"], local["error_m"])
            worst = max(worst, abs(off_server), abs(off_local))
            print(f"{exact['x_m']:9.0f} {exact['y_m']:9.0f} {t_s:8.2f} | {served['height_m']:9.4f} "
                  f"{local['height_m']:9.4f} {exact['height_m']:9.4f} | {off_server:+12.5f} "
                  f"{off_local:+12.5f} {bound:8.4f}")
            for answer in (served, local):
                if abs(answer["height_m"] - exact["height_m"]) > answer["error_m"] + exact["error_m"]:
                    raise SystemExit("demo: an answer is outside its own error bound")
    return worst


def render(server):
    pictures = {
        "from_the_bridge.png": ["--camera", "0,0,12,285,-6", "--time-of-day", "14.5"],
        "against_the_sun.png": ["--camera", "0,0,9,235,-4", "--time-of-day", "15.5"],
    }
    for name, camera in pictures.items():
        path = OUT / name
        start = time.monotonic()
        done = subprocess.run([server.bin_dir / "seaway-view", server.url, "--offscreen", "960x540",
                               "--frames", "1", "--out", str(path), *camera],
                              capture_output=True, text=True)
        if done.returncode != 0 or not path.exists():
            raise SystemExit(f"demo: seaway-view failed: {done.stderr.strip()}")
        print(f"  {path.relative_to(ROOT)}   ({time.monotonic() - start:.1f} s)")


def metric(text, name):
    return next(float(line.split()[1]) for line in text.splitlines() if line.startswith(name + " "))


def stream_rates(server, seconds=4):
    """What the server computes while one client watches."""
    watcher = subprocess.Popen([server.bin_dir / "seaway-query", server.url, "--at=0,0", "--local",
                                "--watch", "5"], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        time.sleep(1.5)
        before, start = server.get("/metrics"), time.monotonic()
        time.sleep(seconds)
        after, elapsed = server.get("/metrics"), time.monotonic() - start
    finally:
        watcher.terminate()
        watcher.wait()

    def rate(name):
        return (metric(after, name) - metric(before, name)) / elapsed

    print(f"  {rate('seaway_keyframes_published_total'):.1f} keyframes/s, "
          f"{rate('seaway_transforms_total'):.1f} transforms/s, "
          f"{rate('seaway_dispatches_total'):.1f} dispatches/s, "
          f"{100 * rate('seaway_device_seconds_total'):.1f} % of the device's time")


def compare_devices(bin_dir):
    """One line: the same sea from the Vulkan path and from the processor, and what each costs."""
    done = subprocess.run([bin_dir / "seaway-bench", "compare", "--scene", SCENE, "--first", DEVICE,
                           "--second", "native"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"demo: seaway-bench compare failed: {done.stderr.strip()}")
    print(f"  {done.stdout.strip()}")


def main():
    bin_dir = pathlib.Path(sys.argv[1]).resolve() / "bin"
    OUT.mkdir(parents=True, exist_ok=True)
    with Server(bin_dir) as server:
        state = json.loads(server.get("/v1/state"))
        print(f"\n{SCENE} on {state['device']}, serving at {server.url}\n")
        for what in ("requested", "realised"):
            sea = state[what]
            print(f"  {what:>9}: Hs {sea['hs_m']:.2f} m, Tp {sea['tp_s']:.1f} s, Tz {sea['tz_s']:.1f} s,"
                  f" from {sea['mean_from_deg']:.0f} deg")
        for warning in state["warnings"]:
            print(f"  warning: {warning}")
        print("\nHeights of five points, now and in ten seconds:")
        worst = compare(server)
        print(f"largest difference from the exact sum: {1000 * worst:.2f} mm\n")
        print("Achieved while one client watches:")
        stream_rates(server)
        print("\nBoth devices:")
        compare_devices(bin_dir)
        print("\nPictures:")
        render(server)
    print("\nEverything is stopped again.")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A minute of a real server whose clients come and go, from its own counters.

    tools/demand_minute.py build/dev/bin/seaway-server [docs/effects/demand.csv]

Starts the server on the gale, native; five clients (those of tests/interop, without decoding) join and
leave by a fixed plan while /metrics is read twice a second. Rows: t_s, sessions that are streamed to, then the
counter of transforms of each effect of each cascade. Needs python3-numpy and python3-zstandard, as tests/interop.
"""
import pathlib
import re
import select
import subprocess
import sys
import threading
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "interop"))
sys.dont_write_bytecode = True
import client  # noqa: E402
import websocket  # noqa: E402

SCENE = "scenes/north_sea_gale.toml"
SECONDS = 62
SAMPLES_A_SECOND = 2
HEIGHT, CHOPPY, SLOPES, GRADIENT, FOAM = {0, 3}, {1, 2, 4, 5}, {6, 7}, {8, 9, 10, 11}, {12}
ALL = 0xFFFFFFFF
# (name, joins at s, leaves at s, cascades by bits, fields)
GUESTS = [
    ("a wave buoy: height of the longest tile", 5, 58, 0b001, HEIGHT),
    ("a game with hulls: height and choppy", 12, 54, ALL, HEIGHT | CHOPPY),
    ("a viewer: slopes and foam too", 21, 46, ALL, HEIGHT | CHOPPY | SLOPES | FOAM),
    ("a second viewer, the same", 28, 50, ALL, HEIGHT | CHOPPY | SLOPES | FOAM),
    ("a tool that wants strains", 35, 41, ALL, HEIGHT | GRADIENT),
]
SESSIONS = re.compile(r"^seaway_net_subscriptions (\d+)$", re.M)
COUNTER = re.compile(r'^seaway_effect_transforms_total\{cascade="(\d+)",effect="(\w+)"\} (\S+)$', re.M)


class Guest(client.Session):
    """Takes tiles and acknowledges keyframes; what they hold is not decoded."""

    def __init__(self, host, port, fields):
        self.parts, self.fields = {}, fields
        super().__init__(host, port)

    def take(self, tile):
        parts = self.parts.setdefault(tile["keyframe"], {})
        parts.setdefault(tile["field"], set()).add(tile["part"])
        if all(len(parts.get(field, ())) == tile["parts"] for field in self.fields):
            del self.parts[tile["keyframe"]]
            self.send("Ack", keyframe=tile["keyframe"])


def attend(host, port, start, guest, stays, failures):
    name, joins, leaves, cascades, fields = guest
    time.sleep(max(0, start + joins - time.monotonic()))
    try:
        session = Guest(host, port, fields)
        joined = time.monotonic() - start
        session.send("Subscribe", request_id=1, cascades=cascades, fields=sum(1 << f for f in fields), credit=8)
        while time.monotonic() < start + leaves:
            held = session.socket.received
            if held or select.select([session.socket.socket], [], [], 0.25)[0]:
                session.receive()
        session.socket.close()
        stays[name] = (joined, time.monotonic() - start)
    except (OSError, client.Refused, websocket.Closed) as error:
        failures.append(f"{name}: {error}")


def metrics(base):
    """How many are streamed to, and transforms by (cascade, effect)."""
    text = urllib.request.urlopen(base + "/metrics", timeout=30).read().decode()
    return int(SESSIONS.search(text).group(1)), {(int(c), e): float(v) for c, e, v in COUNTER.findall(text)}


def record(base, start):
    rows = []
    for sample in range(SECONDS * SAMPLES_A_SECOND + 1):
        time.sleep(max(0, start + sample / SAMPLES_A_SECOND - time.monotonic()))
        rows.append((time.monotonic() - start, *metrics(base)))
    return rows


def write(path, stays, rows):
    columns = sorted(rows[0][2])
    lines = [f"# tools/demand_minute.py, {SCENE}, native; seaway_effect_transforms_total"]
    lines += [f"# guest: {stays[name][0]:.1f} to {stays[name][1]:.1f} s, {name}" for name, *_ in GUESTS]
    lines.append("t_s,sessions," + ",".join(f"{effect}@{cascade}" for cascade, effect in columns))
    lines += [f"{t:.2f},{sessions}," + ",".join(f"{counters[c]:.6g}" for c in columns)
              for t, sessions, counters in rows]
    pathlib.Path(path).write_text("\n".join(lines) + "\n")


def main():
    server, path = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ROOT / "docs/effects/demand.csv"
    process = subprocess.Popen([server, SCENE, "--listen", "127.0.0.1:0", "--device", "native"], cwd=ROOT,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        host, port = re.match(r"ready ws://([\d.]+):(\d+)", process.stdout.readline()).groups()
        start, stays, failures = time.monotonic(), {}, []
        threads = [threading.Thread(target=attend, args=(host, int(port), start, guest, stays, failures)) for guest in GUESTS]
        for thread in threads:
            thread.start()
        rows = record(f"http://{host}:{port}", start)
        for thread in threads:
            thread.join()
    finally:
        process.terminate()
        process.wait()
    if failures:
        sys.exit("\n".join(failures))
    write(path, stays, rows)


if __name__ == "__main__":
    main()

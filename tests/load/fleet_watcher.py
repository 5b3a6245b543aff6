# SPDX-License-Identifier: Apache-2.0
"""Who samples a fleet's sea, and what is asked of the times and heights that he saw."""
import subprocess
import threading
import time


EXTRAPOLATED = 4  # beyond what is held the sea stands: no height of it


class Watcher:
    """A client of the library behind HAProxy: what it samples where it holds the sea, and when each row came."""

    def __init__(self, fleet, number):
        self.rows = []
        self.words = open(fleet.folder / f"watcher-{number}.log", "w")
        self.began_s = time.monotonic()
        self.process = subprocess.Popen(
            [fleet.bin / "seaway-query", f"wss://127.0.0.1:{fleet.balancer_port}", "--ca-file", fleet.certificate, "--local", "--at", f"{number},7",
             "--watch", "20", "--format", "csv", "--timeout", "5"],
            stdout=subprocess.PIPE, stderr=self.words, text=True, bufsize=1)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        names = None
        for line in self.process.stdout:
            fields = line.strip().split(",")
            if names is None:
                names = fields
                continue
            row = dict(zip(names, map(float, fields)))
            row["came_s"] = time.monotonic()
            if not int(row["flags"]) & EXTRAPOLATED:
                self.rows.append(row)

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def way_in_s(self):
        """From its start to its first height."""
        return self.rows[0]["came_s"] - self.began_s

    def worst_gap_s(self, since_s=0.0):
        """Of those that ended since, the one of now among them; by the clock that time.monotonic() shows."""
        times = [row["came_s"] for row in self.rows] + [time.monotonic()]
        return max((b - a for a, b in zip(times, times[1:]) if b >= since_s), default=float("inf"))

    def gaps_s(self):
        times = [row["came_s"] for row in self.rows]
        return [b - a for a, b in zip(times, times[1:])]

    def jump_m(self):
        """How much further a step of 0.1 s or less goes than the water can: speed and half a g, a glide, what both heights may miss."""
        worst = -1.0
        for a, b in zip(self.rows, self.rows[1:]):
            dt = b["t_s"] - a["t_s"]
            if dt <= 0.1:
                speed = max(abs(a["velocity_z_mps"]), abs(b["velocity_z_mps"])) + 0.5
                allowed = (speed + 2.45 * dt) * dt + a["error_m"] + b["error_m"]
                worst = max(worst, abs(b["height_m"] - a["height_m"]) - allowed)
        return worst


def usual_gap_s(watchers):
    """What 99 of 100 times between two heights stay below, those of all clients together."""
    gaps = sorted(gap for watcher in watchers for gap in watcher.gaps_s())
    return gaps[len(gaps) * 99 // 100]

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A fleet on loopback, and what it promises: nats-server, three servers and HAProxy, with the configuration of deploy/fleet. Clients speak TLS,
which ends at HAProxy; at the end, where haproxy-passthrough.cfg leads, at the servers.

While the weather changes every 10 s, one server after the other is killed with -9, NATS is restarted, and the network between one
server and NATS is cut for 20 s. Before that one server hangs (SIGSTOP). Meanwhile heights are asked of all servers at the same sea times, and watchers sample the sea
through HAProxy with the client library. Ends with 1 where a promise was broken.

    tests/load/fleet.py BUILD [--seconds 60] [--scene FILE] [--keep DIR]
"""

import argparse
import csv
import io
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

from fleet_processes import SCENE, Fleet
from fleet_watcher import Watcher, usual_gap_s

CUT_S = 20
WEATHER_EVERY_S = 10
GAP_S_MAX = 2.0
MOVING_GAP_S_MAX = 5.0  # or, on a machine that is slow or crowded, three times the way in of as many clients with nothing broken
WAY_IN_S_MAX = 10  # a way in takes a second or so; what is bounded by it is bounded
WAYS_MAX = 3
GAP_OF_MOVING_MAX = 2.0  # where the same way to another server, with nothing broken, takes more than half of that: a crowded machine
GAP_OF_USUAL_MAX = 5.0  # a way back waits for its turn at the client, at HAProxy, at the server, and again; likewise
HANG_S_MAX = 15.0  # three checks of a second, whoever came to it meanwhile, and a way back; on such a machine likewise
HANG_SEEN_S_MAX = 12.0  # of that, without the way back
HEIGHTS_MIN = 10_000
POINTS = 250  # of a round: two ready servers make HEIGHTS_MIN in 40 rounds, which a minute has where one takes less than 1.5 s
PAUSE_S = 0.5  # between rounds: each asks for times of 1.5 s, so each moment is asked for twice


class Canary(threading.Thread):
    """What the machine itself stands still for: no promise holds for less."""

    def __init__(self):
        super().__init__(daemon=True)
        self.worst_s = 0.0
        self.start()

    def run(self):
        while True:
            began = time.monotonic()
            time.sleep(0.05)
            self.worst_s = min(5.0, max(self.worst_s, time.monotonic() - began - 0.05))


class Comparison:
    """Heights of all servers that call themselves ready, at equal sea times."""

    def __init__(self, fleet, seed=15):
        self.fleet = fleet
        self.random = random.Random(seed)
        self.asked = 0
        self.rounds = 0
        self.wrong = []

    def ask(self, name, points, timeout_s=5):
        text = "".join(f"{x},{y},{t}\n" for x, y, t in points)
        said = subprocess.run([self.fleet.bin / "seaway-query", f"ws://127.0.0.1:{self.fleet.ports[name][0]}",
                               "--points", "-", "--format", "csv", "--timeout", str(timeout_s)],
                              input=text, capture_output=True, text=True, check=False)
        if said.returncode != 0:
            self.why_not = f"exit code {said.returncode}: {said.stderr.strip()}"
            return None
        return list(csv.DictReader(io.StringIO(said.stdout)))

    def once(self, count=POINTS):
        before = [name for name in self.fleet.names if self.fleet.ready(name)]
        now_s = next((json.loads(body)["sea_time_s"] for body in
                      (self.fleet.page(name, "/v1/state")[1] for name in before) if body), None)
        if now_s is None:
            return
        points = [(self.random.uniform(-500, 500), self.random.uniform(-500, 500), now_s + self.random.uniform(-1, 0.5))
                  for _ in range(count)]
        answers = {name: self.ask(name, points) for name in before}
        # One that has stopped being ready meanwhile promises nothing of these.
        sure = [name for name in before if answers[name] and self.fleet.ready(name)]
        if len(sure) < 2:
            return
        self.rounds += 1
        first = answers[sure[0]]
        for name in sure[1:]:
            for point, a, b in zip(points, first, answers[name]):
                self.asked += 1
                off = abs(float(a["height_m"]) - float(b["height_m"]))
                if off > float(a["error_m"]) + float(b["error_m"]) and not (int(a["flags"]) | int(b["flags"])) & 5:
                    self.wrong.append((sure[0], name, point, off))

    def against_truth(self, watchers):
        """What clients sampled, asked again of a server when all is known: how many, without a bound, beyond it."""
        unbound = beyond = 0
        # In order of time, so that the server makes each keyframe once.
        sampled = sorted((row for watcher in watchers for row in watcher.rows), key=lambda row: row["t_s"])
        for first in range(0, len(sampled), 500):
            rows = sampled[first:first + 500]
            truth = self.ask("a", [(row["x_m"], row["y_m"], row["t_s"]) for row in rows], 100)
            if truth is None:
                sys.exit(f"server a does not say what was true of what was sampled: {self.why_not}")
            for row, true in zip(rows, truth):
                if (int(row["flags"]) | int(true["flags"])) & 5:
                    unbound += 1
                elif abs(row["height_m"] - float(true["height_m"])) > row["error_m"] + float(true["error_m"]):
                    beyond += 1
        return len(sampled), unbound, beyond


class Proof:
    """The table: a row for each promise, and whether it was kept."""

    def __init__(self, fleet):
        self.fleet = fleet
        self.fine = True
        self.comparison = Comparison(fleet)
        self.watchers = []
        self.promises, self.refusals, self.stale_seen = 0, 0, False
        self.revivals = []
        self.way_in_s = self.moving_gap_s = self.hung_until_s = 0.0
        self.canary = Canary()

    def say(self, what, value, fine=True):
        self.fine = self.fine and fine
        print(f"{'  ' if fine else '! '}{what:<62} {value}", flush=True)

    def say_took(self, what, took_s, least_s, seen_s=0.0):
        """`least_s` may pass, or `seen_s` and some ways in; and what the machine itself stood still."""
        most_s = max(least_s, seen_s + WAYS_MAX * self.way_in_s) + self.canary.worst_s
        self.say(what, f"{took_s:.2f} of {most_s:.1f} s", took_s < most_s)

    def all_ready(self):
        return all(map(self.fleet.ready, self.fleet.names))

    def begin(self):
        """One server with all clients; two more come, and the clients are spread."""
        fleet = self.fleet
        fleet.start_nats()
        fleet.start_server("a")
        fleet.wait_for(lambda: fleet.ready("a"), "the first server")
        fleet.start_balancer(fleet.names)
        fleet.wait_for(lambda: fleet.up() == {"a"}, "HAProxy's first look")
        self.watchers = [Watcher(fleet, number) for number in range(6)]
        fleet.wait_for(lambda: all(watcher.rows for watcher in self.watchers), "the first heights")
        self.way_in_s = max(watcher.way_in_s() for watcher in self.watchers)
        self.say("clients that came at once have a first height after", f"{self.way_in_s:.2f} s",
                 self.way_in_s < WAY_IN_S_MAX + self.canary.worst_s)
        began = time.monotonic()
        for name in fleet.names[1:]:
            fleet.start_server(name)
        fleet.wait_for(self.all_ready, "the fleet")
        self.say("second and third server ready after", f"{time.monotonic() - began:.1f} s")
        time.sleep(1)  # as HAProxy asks

        def spread():
            count = fleet.sessions()
            return sum(count.values()) == len(self.watchers) and all(count.values())
        # Who is there stays where he is until the operator moves him.
        began = time.monotonic()
        fleet.ask_balancer("shutdown sessions server certain/a")
        fleet.wait_for(spread, "moving sessions")
        self.say("sessions spread over all after", f"{time.monotonic() - began:.1f} s, {fleet.sessions()}")
        time.sleep(GAP_S_MAX)
        self.moving_gap_s = max(watcher.worst_gap_s(began) for watcher in self.watchers)
        self.say_took("and longest without a height meanwhile", self.moving_gap_s, MOVING_GAP_S_MAX)

    def hang(self):
        """One server, of those with clients, says nothing more and keeps its connections."""
        fleet, count = self.fleet, self.fleet.sessions()
        name = max(count, key=count.get)
        began = time.monotonic()
        fleet.processes[name].send_signal(signal.SIGSTOP)
        try:
            fleet.wait_for(lambda: fleet.sessions()[name] == 0 and sum(fleet.sessions().values()) == len(self.watchers),
                           "leaving a server that hangs")
        finally:
            fleet.processes[name].send_signal(signal.SIGCONT)
        took_s = time.monotonic() - began
        self.say_took("clients of a server that hangs are at others after", took_s, HANG_S_MAX, HANG_SEEN_S_MAX)
        fleet.wait_for(self.all_ready, "the fleet, after a hang")
        fleet.wait_for(lambda: all(watcher.rows[-1]["came_s"] > began + took_s for watcher in self.watchers), "heights after a hang")
        gap_s = max(watcher.worst_gap_s(began) for watcher in self.watchers)
        self.say_took("and longest without a height meanwhile", gap_s, HANG_S_MAX, HANG_SEEN_S_MAX)
        self.hung_until_s = time.monotonic()

    def do(self, what, name):
        if what == "kill":
            self.fleet.stop(name, signal.SIGKILL)
            self.later(3, self.fleet.start_server, name)
        elif what == "nats":
            self.fleet.stop("nats", signal.SIGKILL)
            self.later(1, self.fleet.start_nats)
        else:
            self.fleet.line.cut = what == "cut"

    def later(self, seconds, call, *words):
        """In time, however long a comparison takes: a server that has not heard of NATS for two seconds is right to send its clients away."""
        self.revivals.append(threading.Timer(seconds, call, words))
        self.revivals[-1].start()

    def change_weather(self):
        asked = next((name for name in random.sample(self.fleet.names, 3) if self.fleet.ready(name)), None)
        if asked and self.fleet.change(asked, random.uniform(3, 9)):
            self.promises += 1
        else:
            self.refusals += 1

    def end_revivals(self):
        """Nobody comes back any more."""
        for revival in self.revivals:
            revival.cancel()
            revival.join()

    def trouble(self, seconds):
        """Faults at their times, one a round: where a round has taken long, all that is to come is as much later."""
        fleet = self.fleet
        faults = [(3, "kill", "a"), (9, "kill", "b"), (15, "nats", None), (21, "cut", "c"), (21 + CUT_S, "heal", "c"),
                  (47, "kill", "c")]
        began = time.monotonic()
        weather_at = 0.0
        while (now := time.monotonic() - began) < seconds or faults:
            if faults and faults[0][0] <= now:
                due, what, name = faults.pop(0)
                began += now - due
                now = due
                self.do(what, name)
            if now >= weather_at:
                weather_at += WEATHER_EVERY_S
                self.change_weather()
            self.comparison.once()
            time.sleep(PAUSE_S)
            if fleet.line.cut:
                body = fleet.page("c", "/v1/state")[1]
                self.stale_seen = self.stale_seen or (bool(body) and json.loads(body)["journal"]["stale"])
        for revival in self.revivals:
            revival.join()
        fleet.wait_for(self.all_ready, "the fleet, healed")
        while self.comparison.asked < HEIGHTS_MIN and self.comparison.rounds < 200:
            self.comparison.once()

    def judge(self):
        fleet, comparison = self.fleet, self.comparison
        log = {name: fleet.state(name)["journal"]["changes"] for name in fleet.names}
        held = len(set(log.values())) == 1 and min(log.values()) >= self.promises + 1
        self.say("changes acknowledged, refused, and in the log of each", f"{self.promises}, {self.refusals}, {log}",
                 held and self.promises > 0)
        self.say("heights compared at equal sea times between ready servers",
                 f"{comparison.asked} in {comparison.rounds} rounds", comparison.asked >= HEIGHTS_MIN)
        self.say("of these apart by more than their bounds", f"{len(comparison.wrong)} {comparison.wrong[:3] or ''}",
                 not comparison.wrong)
        self.say("the server behind the cut network said that it was stale", self.stale_seen, self.stale_seen)
        gaps = [watcher.worst_gap_s(self.hung_until_s) for watcher in self.watchers]
        for watcher in self.watchers:
            watcher.stop()
        # Faults make some thirty of thousands of gaps: what nearly all stay below is what the machine makes of 50 ms.
        usual_s = usual_gap_s(self.watchers)
        self.say("between two heights 99 of 100 times at most", f"{usual_s:.2f} s")
        self.say("longest time of each client between two heights, then", ", ".join(f"{gap:.2f}" for gap in gaps) + " s",
                 max(gaps) <= max(GAP_S_MAX, GAP_OF_MOVING_MAX * self.moving_gap_s, GAP_OF_USUAL_MAX * usual_s) + self.canary.worst_s)
        self.say("longest time that the machine itself stood still", f"{self.canary.worst_s:.2f} s")
        jump_m = max(watcher.jump_m() for watcher in self.watchers)
        self.say("step that comes nearest to what water and bounds allow", f"{-1e3 * jump_m:.1f} mm below", jump_m <= 0)
        sampled, unbound, beyond = comparison.against_truth(self.watchers)
        self.say("heights that clients sampled, and those without a bound", f"{sampled}, {unbound}",
                 unbound < 0.05 * sampled)
        self.say("of the others beyond their bounds from the sea of the log", beyond, beyond == 0)

    def pass_through(self):
        """TLS ends at a server, and HAProxy sees bytes: one more client, before a server with a certificate."""
        fleet = self.fleet
        for name in [name for name in fleet.processes if name != "nats"]:
            fleet.stop(name)
        fleet.start_server("a", True, "--tls-cert", fleet.certificate, "--tls-key", fleet.key)
        fleet.wait_for(lambda: fleet.listens(fleet.ports["a"][1]), "the server with a certificate")
        fleet.start_balancer(fleet.names, "haproxy-passthrough.cfg")
        watcher = Watcher(fleet, len(self.watchers))
        fleet.wait_for(lambda: len(watcher.rows) >= 20, "heights through TLS that ends at the server")
        watcher.stop()
        self.say("heights through HAProxy by TLS that ends at a server", len(watcher.rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=60, help="of trouble, 60 and more")
    parser.add_argument("--scene", default=SCENE, help="of the servers: %(default)s")
    parser.add_argument("--keep", metavar="DIR", help="leaves logs there")
    options = parser.parse_args()
    if options.seconds < 60:
        parser.error("--seconds: 60 and more")
    with tempfile.TemporaryDirectory(prefix="seaway-fleet-") as folder:
        if options.keep:
            folder = options.keep
            os.makedirs(folder, exist_ok=True)
        fleet = Fleet(options.build, folder, scene=os.path.abspath(options.scene))
        proof = Proof(fleet)
        try:
            proof.begin()
            proof.hang()
            proof.trouble(options.seconds)
            proof.judge()
            proof.pass_through()
        finally:
            proof.end_revivals()
            fleet.stop_all()
    print("the fleet kept its promises" if proof.fine else "a promise was broken")
    return 0 if proof.fine else 1


if __name__ == "__main__":
    sys.exit(main())

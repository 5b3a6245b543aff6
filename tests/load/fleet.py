#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A fleet on loopback, and what it promises: nats-server, three servers and HAProxy, with the configuration of deploy/fleet. Clients speak TLS,
which ends at HAProxy; at the end, where haproxy-passthrough.cfg leads, at the servers.

While the weather changes every 10 s, one server after the other is killed with -9, NATS is restarted, and the network between one
server and NATS is cut for 20 s. Before that one server hangs (SIGSTOP). Meanwhile heights are asked of all servers at the same sea times, and watchers sample the sea
through HAProxy with the client library. Ends with 1 where a promise was broken.

    tests/load/fleet.py BUILD [--seconds 60] [--keep]
"""

import argparse
import csv
import http.client
import io
import json
import os
import pathlib
import random
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

from fleet_watcher import Watcher

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SCENE = SOURCE / "scenes/calm.toml"
WORLD = "north-sea"
TOKEN = "fleet-of-the-test"
CUT_S = 20
WEATHER_EVERY_S = 10
GAP_S_MAX = 2.0
MOVING_GAP_S_MAX = 5.0
GAP_OF_MOVING_MAX = 2.0  # where the same way to another server, with nothing broken, takes more than half of that: a crowded machine
HANG_S_MAX = 15.0  # three checks of a second, and a client's way back on a crowded machine
HEIGHTS_MIN = 10_000


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Line:
    """A TCP proxy that can be cut: nothing comes through, and nobody is told."""

    def __init__(self, to_port):
        self.to_port = to_port
        self.cut = False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            near, _ = self.listener.accept()
            threading.Thread(target=self._carry, args=(near,), daemon=True).start()

    def _carry(self, near):
        while self.cut:
            time.sleep(0.05)
        try:
            with near, socket.create_connection(("127.0.0.1", self.to_port)) as far:
                while True:
                    if self.cut:
                        time.sleep(0.05)
                        continue
                    ready, _, _ = select.select([near, far], [], [], 0.1)
                    for one in ready:
                        data = one.recv(65536)
                        if not data:
                            return
                        if not self.cut:
                            (far if one is near else near).sendall(data)
        except OSError:
            pass


class Fleet:
    def __init__(self, build, folder, names=("a", "b", "c"), scene=SCENE):
        self.bin = pathlib.Path(build).resolve() / "bin"
        self.folder = pathlib.Path(folder)
        self.processes = {}
        self.nats_port = free_port()
        self.balancer_port = free_port()
        self.line = Line(self.nats_port)
        self.names = list(names)
        self.scene = scene
        self.ports = {name: (free_port(), free_port()) for name in self.names}
        (self.folder / "admin.token").write_text(TOKEN + "\n")
        (self.folder / "nats.credentials").write_text("seaway:change-this\n")
        (self.folder / "nats.credentials").chmod(0o600)
        (self.folder / "admin.token").chmod(0o600)
        self.certificate, self.key = self.folder / "sea.crt", self.folder / "sea.key"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=sea", "-addext",
                        "subjectAltName=IP:127.0.0.1", "-keyout", self.key, "-out", self.certificate], check=True, capture_output=True)
        (self.folder / "sea.pem").write_text(self.certificate.read_text() + self.key.read_text())

    def start(self, name, *words):
        log = open(self.folder / f"{name}.log", "ab")
        self.processes[name] = subprocess.Popen([str(word) for word in words], stdout=log, stderr=log, cwd=SOURCE)

    def stop(self, name, how=signal.SIGTERM):
        process = self.processes.pop(name)
        process.send_signal(how)
        process.wait()

    def stop_all(self):
        for name in list(self.processes):
            self.stop(name, signal.SIGKILL)

    def start_nats(self, *words):
        """With the users and rights of deploy/fleet/nats.conf."""
        text = (SOURCE / "deploy/fleet/nats.conf").read_text()
        config = self.folder / "nats.conf"
        config.write_text(f'listen: "127.0.0.1:{self.nats_port}"\njetstream {{ store_dir: "{self.folder}/nats" }}\n'
                          + text[text.index("authorization {"):])
        self.start("nats", "/usr/sbin/nats-server", "-c", config, *words)
        self.wait_for(lambda: self.listens(self.nats_port), "NATS")

    def start_server(self, name, journal=True, *words):
        """With the world's journal or a sea of its own."""
        port, health = self.ports[name]
        nats = self.line.port if name == "c" else self.nats_port
        if journal:
            words = [*words, "--journal", f"nats://127.0.0.1:{nats}/{WORLD}", "--journal-credentials", self.folder / "nats.credentials"]
        self.start(name, self.bin / "seaway-server", self.scene, "--device", "native", "--listen", f"127.0.0.1:{port}",
                   "--health-listen", f"127.0.0.1:{health}", "--admin-token-file", self.folder / "admin.token", "--retry-after", "0.5",
                   "--connections-per-address", "0", "--sessions-without-hello-per-address", "0", *words)

    def start_balancer(self, names, file="haproxy.cfg"):
        """With what deploy/fleet has, on these ports."""
        text = (SOURCE / "deploy/fleet" / file).read_text()
        text = text.replace("/run/haproxy/seaway.sock", f"{self.folder}/haproxy.sock")
        text = text.replace("/etc/haproxy/sea.pem", f"{self.folder}/sea.pem")
        text = text.replace("maxconn 20000", "maxconn 1000")  # as few open files as a test may have
        text = text.replace("bind :443", f"bind 127.0.0.1:{self.balancer_port}")
        for name in self.names:
            port, health = self.ports[name]
            there = "" if name in names else " disabled"
            text = re.sub(rf"server {name} .*", f"server {name} 127.0.0.1:{port} port {health}{there}", text)
        config = self.folder / file
        config.write_text(text)
        self.start("haproxy", "/usr/sbin/haproxy", "-f", config)
        self.wait_for(lambda: self.listens(self.balancer_port), "HAProxy")

    def ask_balancer(self, words):
        with socket.socket(socket.AF_UNIX) as line:
            line.connect(f"{self.folder}/haproxy.sock")
            line.sendall(words.encode() + b"\n")
            return b"".join(iter(lambda: line.recv(65536), b"")).decode()

    def sessions(self):
        """Of each server as HAProxy counts them."""
        rows = csv.DictReader(io.StringIO(self.ask_balancer("show stat").lstrip("# ")))
        return {row["svname"]: int(row["scur"]) for row in rows
                if row["pxname"] == "certain" and row["svname"] in self.names}

    def up(self):
        """The servers that HAProxy would send somebody to: all of them, until it has looked."""
        rows = csv.DictReader(io.StringIO(self.ask_balancer("show stat").lstrip("# ")))
        return {row["svname"] for row in rows
                if row["pxname"] == "certain" and row["svname"] in self.names and row["status"].startswith("UP")}

    @staticmethod
    def listens(port):
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    @staticmethod
    def wait_for(condition, what, limit_s=60):
        until = time.monotonic() + limit_s
        while not condition():
            if time.monotonic() > until:
                raise RuntimeError(f"{what} took longer than {limit_s} s")
            time.sleep(0.02)

    def page(self, name, path):
        line = http.client.HTTPConnection("127.0.0.1", self.ports[name][0], timeout=5)
        try:
            line.request("GET", path, headers={"Authorization": f"Bearer {TOKEN}"})
            answer = line.getresponse()
            return answer.status, answer.read().decode()
        except OSError:
            return 0, ""
        finally:
            line.close()

    def ready(self, name):
        return name in self.processes and self.page(name, "/readyz")[0] == 200

    def change(self, name, wind_mps):
        """What seaway-ctl says: the promise, or None."""
        said = subprocess.run([self.bin / "seaway-ctl", f"ws://127.0.0.1:{self.ports[name][0]}", "--token-file",
                               self.folder / "admin.token", "--timeout", "8", "set",
                               f"systems.0.wind_speed_10m_mps={wind_mps:.2f}", "--over", "10s"],
                              capture_output=True, text=True, check=False)
        return json.loads(said.stdout) if said.returncode == 0 else None


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

    def once(self, count=250):
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
        sampled = unbound = beyond = 0
        for watcher in watchers:
            for first in range(0, len(watcher.rows), 500):
                rows = watcher.rows[first:first + 500]
                truth = self.ask("a", [(row["x_m"], row["y_m"], row["t_s"]) for row in rows], 100)
                if truth is None:
                    sys.exit(f"server a does not say what was true of what was sampled: {self.why_not}")
                for row, true in zip(rows, truth):
                    sampled += 1
                    if (int(row["flags"]) | int(true["flags"])) & 5:
                        unbound += 1
                    elif abs(row["height_m"] - float(true["height_m"])) > row["error_m"] + float(true["error_m"]):
                        beyond += 1
        return sampled, unbound, beyond


class Proof:
    """The table: a row for each promise, and whether it was kept."""

    def __init__(self, fleet):
        self.fleet = fleet
        self.fine = True
        self.comparison = Comparison(fleet)
        self.watchers = []
        self.promises, self.refusals, self.stale_seen = 0, 0, False
        self.revive = []
        self.moving_gap_s = self.hung_until_s = 0.0

    def say(self, what, value, fine=True):
        self.fine = self.fine and fine
        print(f"{'  ' if fine else '! '}{what:<62} {value}", flush=True)

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
        self.say("and longest without a height meanwhile", f"{self.moving_gap_s:.2f} s", self.moving_gap_s < MOVING_GAP_S_MAX)

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
        self.say("clients of a server that hangs are at others after", f"{took_s:.1f} s", took_s < HANG_S_MAX)
        fleet.wait_for(self.all_ready, "the fleet, after a hang")
        fleet.wait_for(lambda: all(watcher.rows[-1]["came_s"] > began + took_s for watcher in self.watchers), "heights after a hang")
        gaps = [watcher.worst_gap_s(began) for watcher in self.watchers]
        self.say("and longest without a height meanwhile", f"{max(gaps):.1f} s", max(gaps) < HANG_S_MAX)
        self.hung_until_s = time.monotonic()

    def do(self, what, name, now):
        if what == "kill":
            self.fleet.stop(name, signal.SIGKILL)
            self.revive.append((now + 3, name))
        elif what == "nats":
            self.fleet.stop("nats", signal.SIGKILL)
            self.revive.append((now + 1, "nats"))
        else:
            self.fleet.line.cut = what == "cut"

    def change_weather(self):
        asked = next((name for name in random.sample(self.fleet.names, 3) if self.fleet.ready(name)), None)
        if asked and self.fleet.change(asked, random.uniform(3, 9)):
            self.promises += 1
        else:
            self.refusals += 1

    def trouble(self, seconds):
        fleet = self.fleet
        faults = [(3, "kill", "a"), (9, "kill", "b"), (15, "nats", None), (21, "cut", "c"), (21 + CUT_S, "heal", "c"),
                  (47, "kill", "c")]
        began = time.monotonic()
        weather_at = 0.0
        while (now := time.monotonic() - began) < seconds:
            while faults and faults[0][0] <= now:
                _, what, name = faults.pop(0)
                self.do(what, name, now)
            for due in [due for due in self.revive if due[0] <= now]:
                self.revive.remove(due)
                if due[1] == "nats":
                    fleet.start_nats()
                else:
                    fleet.start_server(due[1])
            if now >= weather_at:
                weather_at += WEATHER_EVERY_S
                self.change_weather()
            self.comparison.once()
            time.sleep(0.1)
            if fleet.line.cut:
                body = fleet.page("c", "/v1/state")[1]
                self.stale_seen = self.stale_seen or (bool(body) and json.loads(body)["journal"]["stale"])
        while self.comparison.asked < HEIGHTS_MIN and self.comparison.rounds < 200:
            self.comparison.once()
        fleet.wait_for(self.all_ready, "the fleet, healed")

    def judge(self):
        fleet, comparison = self.fleet, self.comparison
        log = {name: json.loads(fleet.page(name, "/v1/state")[1])["journal"]["changes"] for name in fleet.names}
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
        self.say("longest time of each client between two heights, then", ", ".join(f"{gap:.2f}" for gap in gaps) + " s",
                 max(gaps) <= max(GAP_S_MAX, GAP_OF_MOVING_MAX * self.moving_gap_s))
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
    parser.add_argument("--keep", metavar="DIR", help="leaves logs there")
    options = parser.parse_args()
    if options.seconds < 60:
        parser.error("--seconds: 60 and more")
    with tempfile.TemporaryDirectory(prefix="seaway-fleet-") as folder:
        if options.keep:
            folder = options.keep
            os.makedirs(folder, exist_ok=True)
        fleet = Fleet(options.build, folder)
        try:
            proof = Proof(fleet)
            proof.begin()
            proof.hang()
            proof.trouble(options.seconds)
            proof.judge()
            proof.pass_through()
        finally:
            fleet.stop_all()
    print("the fleet kept its promises" if proof.fine else "a promise was broken")
    return 0 if proof.fine else 1


if __name__ == "__main__":
    sys.exit(main())

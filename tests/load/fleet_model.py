#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How many servers a world takes: costs measured on one to four servers here, a model of them, and what it says of 1e4 to 1e6 clients.

    fleet_model.py --measure BUILD   runs servers, NATS and swarms (12 minutes, nothing else running): docs/fleet/runs.csv, nats.csv
    fleet_model.py --measure-words   runs NATS and who says to all what so many servers would (2 minutes): docs/fleet/words.csv
    fleet_model.py --write           the tables of docs/operations.md from these files
    fleet_model.py                   whether the page has them

A server's processor time is a sum: being there, a session and its ping a second, a stream that somebody reads (synthesis and encoding, once for
all), a keyframe handed to a client, a megabyte of it, being asked, a question. Terms are fitted by least squares, of relative errors and none
negative, to runs that hold one thing at a time; runs of everything at once, on one server and on fleets, are what its error is stated on.
"""
import argparse
import concurrent.futures
import csv
import io
import json
import math
import pathlib
import re
import selectors
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from page_text import number, table  # noqa: E402
from fleet_processes import Fleet, SOURCE, free_port  # noqa: E402

RUNS = SOURCE / "docs/fleet/runs.csv"
NATS = SOURCE / "docs/fleet/nats.csv"
WORDS = SOURCE / "docs/fleet/words.csv"
PEER_CLOCKS = (SOURCE / "server/journal/peer_clocks.h").read_text()
PAGE = SOURCE / "docs/operations.md"
BEGIN, END = "<!-- sizes: tests/load/fleet_model.py --write -->", "<!-- end of sizes -->"
SCENE = SOURCE / "scenes/north_sea_gale.toml"
SECONDS = 15
SESSIONS_MOST = 4000  # of one server, here: silent ones; of readers docs/fleet/runs.csv holds fewer
NETWORK_CORES = 0.5   # of its one network thread that a plan uses: the rest is for who comes back at once
ASKS = 1.0            # single points a second of each client of the plan
KINDS = ["predicted", "compact", "whole"]

# What one run holds: kind of stream, its readers, sessions that only ping, askers, questions a second of each.
ALONE = [("", 0, 0, 0, 0), ("", 0, 1000, 0, 0), ("", 0, SESSIONS_MOST, 0, 0),
         *((kind, readers, 0, 0, 0) for kind in KINDS for readers in (1, 100, 300)),
         ("predicted", 1000, 0, 0, 0), ("", 0, 0, 1, 10), ("", 0, 0, 50, 10), ("", 0, 0, 100, 20)]
MIXED = [("predicted", 150, 0, 50, 4), ("compact", 80, 0, 50, 4)]
SERVERS = [1, 2, 3, 4]
SPEAKERS = [4, 16, 64, 128, 255]

TERMS = [("there", "a server that runs", "us/s", lambda r: 1),
         ("session", "a session, with a ping a second", "us/s", lambda r: r["sessions"]),
         *((kind, f"a {kind} stream that somebody reads", "us/s", lambda r, kind=kind: r["kind"] == kind) for kind in KINDS),
         ("keyframe", "a keyframe handed to a client", "us", lambda r: r["keyframes_a_s"]),
         ("megabyte", "a megabyte handed on", "us", lambda r: r["mb_a_s"]),
         ("asked", "being asked about now", "us/s", lambda r: r["asks_a_s"] > 0),
         ("ask", "a question of one point", "us", lambda r: r["asks_a_s"])]


class Model:
    """Cores of a server as a sum of terms."""

    def __init__(self, runs, column):
        self.column = column
        rows = numpy.array([[float(term[3](run)) for term in TERMS] for run in runs])
        wanted = numpy.array([run[column] for run in runs])
        # Processor time is counted in hundredths of a second, twice in a run: less than that says nothing.
        weights = 1 / numpy.maximum(wanted, 0.02 / SECONDS)
        kept = list(range(len(TERMS)))
        while True:
            found = numpy.linalg.lstsq(rows[:, kept] * weights[:, None], wanted * weights, rcond=None)[0]
            if min(found) >= 0:
                break
            kept.remove(kept[int(numpy.argmin(found))])
        self.terms = dict.fromkeys((term[0] for term in TERMS), 0.0)
        self.terms.update({TERMS[index][0]: float(value) for index, value in zip(kept, found)})

    def __call__(self, run):
        return sum(self.terms[name] * float(count(run)) for name, _, _, count in TERMS)

    def errors(self, runs):
        """Of each run: by how much the model is above, as a share of what was measured."""
        return [self(run) / run[self.column] - 1 for run in runs]


class Plan:
    """A fleet for so many clients who all read one kind of stream and ask."""

    def __init__(self, clients, kind, runs):
        alike = [run for run in runs if run["kind"] == kind and run["place"] == "alone" and run["readers"] >= 100]
        each = {column: numpy.median([run[column] / run["readers"] for run in alike]) for column in ("keyframes_a_s", "mb_a_s")}
        network, cores = Model(of_place(runs, "alone"), "busiest_cores"), Model(of_place(runs, "alone"), "cores")

        def load(count):
            return {"kind": kind, "sessions": count, "asks_a_s": ASKS * count, **{c: v * count for c, v in each.items()}}
        self.sessions = max((count for count in range(100, SESSIONS_MOST + 1, 100) if network(load(count)) <= NETWORK_CORES), default=1)
        self.servers = max(2, math.ceil(clients / self.sessions) + max(1, math.ceil(0.02 * clients / self.sessions)))
        share = load(clients / self.servers)
        self.busiest_cores, self.cores = network(share), self.servers * cores(share)
        self.gbit_a_s = 8e-3 * each["mb_a_s"] * clients
        self.clients = clients
        # What a server of the plan is asked for over the most of it that one run has held: above 1 it is the model's word alone.
        self.beyond = {what: (clients / self.servers if what == "readers" else share[what]) / max(run[what] for run in considered)
                       for what, considered in (("sessions", runs), ("readers", alike), ("mb_a_s", runs), ("asks_a_s", runs))}


def constant(name):
    return int(re.search(rf"{name} = ([\d']+);", PEER_CLOCKS)[1].replace("'", ""))


def word_bytes(servers):
    """Of what each server says to all once a second (PeerClocks::word), with a name of 16 letters and times of 12 digits, some days."""
    return 58 + 37 * min(servers - 1, constant("answered_max"))


class Engine:
    """What the log costs NATS while nobody changes the sea: what each server asks of the log, and its words, in once and out to each."""

    def __init__(self, rows, words):
        counts = numpy.array([row["servers"] for row in rows])
        said = numpy.array([[self.words(column, count) for count in counts] for column in ("messages_a_s", "kilobytes_a_s")])
        measured = [[row[column] for row in rows] for column in ("messages_a_s", "kilobytes_a_s")]
        self.asked = {column: float(numpy.mean((of_all - of_words) / counts)) for column, of_all, of_words in
                      zip(("messages_a_s", "kilobytes_a_s"), measured, said)}
        # Of words: a part of who says them, a part of each that is handed on; of one server the latter is nothing.
        speakers = numpy.array([row["servers"] for row in words])
        weights = 1 / numpy.array([row["cores"] for row in words])
        parts = numpy.stack([speakers, speakers**2], 1) * weights[:, None]
        self.word_cores = numpy.maximum(numpy.linalg.lstsq(parts, numpy.ones(len(words)), rcond=None)[0], 0)
        self.asked["cores"] = float(max(numpy.mean([(row["cores"] - self.words("cores", row["servers"])) / row["servers"] for row in rows]), 0))

    def words(self, column, servers):
        if column == "cores":
            return self.word_cores[0] * servers + self.word_cores[1] * servers**2
        return (servers + servers**2) * (1 if column == "messages_a_s" else 1e-3 * word_bytes(servers))

    def __call__(self, column, servers):
        return self.asked[column] * servers + self.words(column, servers)


class Room:
    """For sessions, as deploy/fleet ships it and as its comments have it for larger servers."""

    def __init__(self):
        fleet, balancer = ((SOURCE / "deploy/fleet" / name).read_text() for name in ("fleet.toml", "haproxy.cfg"))
        self.shipped = int(re.search(r"sessions_max = (\d+);", (SOURCE / "server/net/options.h").read_text())[1])
        self.told, self.connections = (int(re.search(rf"\n# {name}-max = (\d+)\n", fleet)[1]) for name in ("sessions", "connections"))
        self.all_shipped, self.balanced_shipped = (int(re.search(rf"{where}maxconn (\d+)", balancer)[1]) for where in (r"\n    ", "default-server .* "))
        self.balanced = int(re.search(r"(\d+) with those of the comments", balancer)[1])


def of_place(runs, place):
    return [run for run in runs if run["place"] == place]


def read(path):
    def value(text):
        try:
            return float(text)
        except ValueError:
            return text
    with open(path) as file:
        return [{name: value(text) for name, text in row.items()} for row in csv.DictReader(line for line in file if line[0] != "#")]


def write(path, note, rows):
    path.parent.mkdir(exist_ok=True)
    with open(path, "w") as file:
        file.write(f"# {note}\n")
        out = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        out.writeheader()
        out.writerows(rows)


def swarm_row(fleet, name, words):
    """What load_swarm says of a server of the fleet that runs."""
    said = subprocess.run([str(word) for word in [
        fleet.bin / "load_swarm", "answers", "--attach", f"{fleet.ports[name][0]}:{fleet.processes[name].pid}", *words]],
        capture_output=True, text=True, check=True)
    return next(csv.DictReader(io.StringIO(said.stdout)))


class Measurement:
    """Servers of the gale, of their own or of one world, and swarms before them."""

    def __init__(self, build, folder):
        self.fleet = Fleet(build, folder, ["a", "b", "c", "d"], SCENE)
        self.runs = []

    def swarm(self, name, what):
        """One swarm before one running server: its row."""
        kind, readers, idle, askers, asks = what
        row = swarm_row(self.fleet, name, [
            "--clients", readers or idle, "--askers", askers, "--asks", asks or 1, "--pings", 1, "--seconds", SECONDS, "--warm-up", 5,
            "--fields", "surface" if kind else "none", *([f"--{kind}"] if kind in ("predicted", "compact") else [])])
        return {"kind": kind, "readers": readers, "sessions": readers + idle + askers, "keyframes_a_s": row["keyframes_a_s"],
                "mb_a_s": row["mb_a_s"], "asks_a_s": row["answers_a_s"], "cores": row["cpu_cores"], "busiest_cores": row["busiest_cores"],
                "resident_mb": row["rss_mb"], "lost": row["lost"], "load": row["load"]}

    def fresh(self, names, nats):
        """Servers that nobody has asked anything yet: what was asked before is in no run."""
        self.fleet.stop_all()
        if nats:
            self.fleet.start_nats("-m", self.monitor)
        for name in names:
            self.fleet.start_server(name, nats, "--sessions-max", 5000, "--connections-max", 6000, "--request-bytes-per-address", 0)
        self.fleet.wait_for(lambda: all(map(self.fleet.ready, names)), "the servers", 120)
        time.sleep(2)

    def all_at_once(self, place, names, what, nats):
        self.fresh(names, nats)
        with concurrent.futures.ThreadPoolExecutor(len(names)) as pool:
            for row in pool.map(lambda name: self.swarm(name, what), names):
                self.runs.append({"place": place, **row})
                print(self.runs[-1], flush=True)

    def everything(self):
        for what in ALONE:
            self.all_at_once("alone", ["a"], what, False)
        for what in MIXED:
            for _ in range(2):
                self.all_at_once("mixed", ["a"], what, False)
            for count in SERVERS:
                self.all_at_once(f"fleet of {count}", self.fleet.names[:count], what, True)
        return self.runs

    monitor = free_port()

    def engine(self, count):
        """NATS with so many servers."""
        self.fresh(self.fleet.names[:count], True)
        return {"servers": count, **engine_rates(self.fleet, self.monitor, time.sleep)}


def engine_rates(fleet, monitor, wait):
    """Of NATS over 20 s, while `wait` waits for so long, by its own monitoring and the system's clock of its process."""
    pid = fleet.processes["nats"].pid

    def look():
        with urllib.request.urlopen(f"http://127.0.0.1:{monitor}/varz") as answer:
            said = json.load(answer)
        ticks = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        return numpy.array([said["in_msgs"] + said["out_msgs"], 1e-3 * (said["in_bytes"] + said["out_bytes"]), sum(map(int, ticks)) / 100])
    before, began = look(), time.monotonic()
    wait(20)
    rates = (look() - before) / (time.monotonic() - began)
    return {c: f"{r:.4g}" for c, r in zip(("messages_a_s", "kilobytes_a_s", "cores"), rates)}


class Speakers:
    """So many connections to NATS, each of which says a word to all once a second, as long as a server's, and reads what it hears."""

    def __init__(self, port, count):
        self.port, self.lines, self.heard = port, [], selectors.DefaultSelector()
        word = b"x" * word_bytes(count)
        self.word = b"PUB seaway.north-sea.clock %d\r\n%s\r\n" % (len(word), word)
        for _ in range(count):
            line = socket.create_connection(("127.0.0.1", port))
            line.sendall(b'CONNECT {"verbose":false,"user":"seaway","pass":"change-this"}\r\nSUB seaway.north-sea.clock 1\r\n')
            self.heard.register(line, selectors.EVENT_READ)
            self.lines.append(line)

    def speak(self, seconds):
        began, said = time.monotonic(), 0
        while (now_s := time.monotonic() - began) < seconds:
            while said < now_s * len(self.lines):  # one after the other, spread over the second
                self.lines[said % len(self.lines)].sendall(self.word)
                said += 1
            for key, _ in self.heard.select(0.5 / len(self.lines)):
                if b"PING\r\n" in key.fileobj.recv(1 << 20):
                    key.fileobj.sendall(b"PONG\r\n")

    def close(self):
        for line in self.lines:
            line.close()


def measure_words():
    rows = []
    with tempfile.TemporaryDirectory(prefix="seaway-words-") as folder:
        fleet, monitor = Fleet(folder, folder, ["a"], SCENE), free_port()
        fleet.start_nats("-m", monitor)
        try:
            for count in SPEAKERS:
                speakers = Speakers(fleet.nats_port, count)
                speakers.speak(3)
                rows.append({"servers": count, **engine_rates(fleet, monitor, speakers.speak)})
                speakers.close()
                print(rows[-1], flush=True)
        finally:
            fleet.stop_all()
    write(WORDS, "fleet_model.py --measure-words: as nats.csv, of connections that say and hear words of the length that so many servers have", rows)


def measure(build):
    with tempfile.TemporaryDirectory(prefix="seaway-sizes-") as folder:
        measurement = Measurement(build, folder)
        try:
            runs = measurement.everything()
            rows = [measurement.engine(count) for count in SERVERS]
        finally:
            measurement.fleet.stop_all()
    write(RUNS, f"fleet_model.py --measure: gale, six fields at 1 cm, native, 2 cores that swarms share, {SECONDS} s a run; fields in order of use", runs)
    write(NATS, "fleet_model.py --measure: all messages and bytes through nats-server, in and out, nobody changes the sea", rows)


def beyond_words(runs, plans):
    """Where plans ask more of a server than has been measured."""
    silent = max(run["sessions"] for run in runs if not run["kind"])
    readers = {kind: max(run["readers"] for run in runs if run["kind"] == kind) for kind, *_ in MIXED}
    most = {kind: max((plan for of, plan in plans if of == kind), key=lambda plan: plan.beyond["readers"]) for kind in readers}
    asked = max(run["asks_a_s"] for run in runs)
    return (f"**What of that was measured.** {silent:.0f} sessions of one server were silent ones, which ping once a second; "
            + " and ".join(f"{count:.0f} {kind}" for kind, count in readers.items()) + " readers are the most that one server had, and "
            f"{asked:.0f} questions a second. A server of this table has up to "
            + " and ".join(f"{plan.beyond['readers']:.0f} times as many {kind} readers" for kind, plan in most.items())
            + f", and {max(plan.beyond['asks_a_s'] for plan in most.values()):.1f} times the questions: there it is the sum above that says so, and nothing else.")


def page():
    runs, engine = read(RUNS), Engine(read(NATS), read(WORDS))
    alone, mixed = of_place(runs, "alone"), [run for run in runs if run["place"] != "alone"]
    models = Model(alone, "cores"), Model(alone, "busiest_cores")
    lines = [table(["what", "processor time of the server", "of that its busiest thread"],
                   [[what, *(f"{number(1e6 * model.terms[name])} {unit}" for model in models)] for name, what, unit, _ in TERMS]), ""]
    within = [max(abs(error) for error in model.errors(mixed)) for model in models]
    busy = max(abs(error) for error in models[0].errors([run for run in alone if run["cores"] > 0.02]))
    lines += [f"Its error: {100 * busy:.0f} % at most of the runs that it was fitted to (those above 0.02 cores), {100 * within[0]:.0f} % of {len(mixed)} runs "
              f"of readers and askers together on one to {max(SERVERS)} servers, which it was not fitted to, and {100 * within[1]:.0f} % of their busiest threads.", ""]
    rows = []
    for place in dict.fromkeys(run["place"] for run in mixed):
        cost = {kind: [run["cores"] for run in of_place(runs, place) if run["kind"] == kind] for kind, *_ in MIXED}
        ratios = [numpy.mean(costs) / numpy.mean([run["cores"] for run in of_place(runs, "mixed") if run["kind"] == kind])
                  for kind, costs in cost.items()]
        rows.append([place, *(f"{numpy.mean(costs):.3f} ({min(costs):.3f} to {max(costs):.3f})" for costs in cost.values()),
                     ", ".join(f"{ratio:.2f}" for ratio in ratios)])
    what = [f"{readers} {kind} readers, {askers} who ask {asks} times a second" for kind, readers, _, askers, asks in MIXED]
    lines += [table(["cores of one server", *what, "of what it costs alone"], rows), ""]
    plans = [[kind, Plan(clients, kind, runs)] for kind in ("predicted", "compact") for clients in (1e4, 1e5, 1e6)]
    lines += [table(["clients", "stream", "servers, spare ones included", "sessions each", "cores in all", "Gbit/s", "NATS: messages a second, MB/s, cores"],
                    [[f"{plan.clients:.0f}", kind, str(plan.servers), f"{plan.clients / plan.servers:.0f}", number(plan.cores, 2), number(plan.gbit_a_s, 2),
                      f"{engine('messages_a_s', plan.servers):.0f}, {number(1e-3 * engine('kilobytes_a_s', plan.servers))}, "
                      f"{number(engine('cores', plan.servers))}"] for kind, plan in plans])]
    off = {column: 100 * max(abs(foretold(row["servers"]) / row[column] - 1) for row in rows) for column, foretold, rows in (
        ("messages_a_s", lambda n: engine("messages_a_s", n), read(NATS)), ("kilobytes_a_s", lambda n: engine("kilobytes_a_s", n), read(NATS)),
        ("cores", lambda n: engine.words("cores", n), read(WORDS)))}
    lines += ["", f"Of NATS: what servers ask of the log was measured with one to {max(SERVERS)} of them, where the messages are within {off['messages_a_s']:.1f} % of the sum and the bytes "
              f"within {off['kilobytes_a_s']:.1f} %. What they say to each other once a second, {word_bytes(constant('peers_max'))} bytes at most from each to each, was said by up to "
              f"{max(SPEAKERS)} connections; the cores that it took are within {off['cores']:.0f} % of the sum. A server hears {constant('peers_max')} others at most."]
    lines += ["", beyond_words(runs, plans)]
    room = Room()
    lines += ["", f"**A server takes {room.shipped} sessions unless it is told otherwise.** For the {max(plan.clients / plan.servers for _, plan in plans):.0f} of the table, and {room.told} where "
              f"others have failed: `sessions-max = {room.told}` and `connections-max = {room.connections}` in `deploy/fleet/fleet.toml`, where they stand as comments, and `maxconn {room.balanced}` in place of "
              f"{room.balanced_shipped} for the servers of both backends in HAProxy's configuration: between the two, so that a server that is full says so itself. `maxconn` of HAProxy as a whole "
              f"is {room.all_shipped} there: all clients and a quarter more, for who comes back at once, {1.25 * plans[0][1].clients:.0f} to {1.25 * plans[2][1].clients:.0f} of this table. Each is two open files "
              "(`LimitNOFILE=` of its unit), and what one machine does not carry goes through several of them, each before all servers."]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--measure", metavar="BUILD", help="takes the figures anew")
    parser.add_argument("--measure-words", action="store_true", help="those of NATS with many servers")
    parser.add_argument("--write", action="store_true", help="into docs/operations.md")
    options = parser.parse_args()
    if options.measure:
        measure(options.measure)
    if options.measure_words:
        measure_words()
    text = PAGE.read_text()
    start, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    if options.write:
        PAGE.write_text(text[:start] + "\n" + page() + "\n" + text[end:])
    elif text[start:end].strip() != page():
        print("docs/operations.md has other sizes than docs/fleet/*.csv give: fleet_model.py --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What one client's flood costs another: a server, a healthy subscriber who also asks single points, and an
attack, each in a process of its own. Prints one row: keyframes that the healthy one lost, how long its
single points took, what the attack was answered, and the server's memory before, at the most and afterwards.

    load_price.py ATTACK [SECONDS] [--server PROGRAM] [--scene FILE] [--after SECONDS] [--probe KIND] [--device NAME]

Attacks: quiet, fetch (8 far times, all fields, again and again), points (4096 points at 8 times x 16),
exact (256 x 16), leave (100 MB of legal queries, then gone; the healthy one's are timed afterwards too),
crowd (128 small fetches at once), maps (4096 x 4096, by many), slow (two readers of maps who read hardly),
unread (64 sessions that fetch and ask all they may and read nothing).
Written from docs/protocol.md with the client of tests/interop. Ends by itself; run by hand.
"""
import argparse
import collections
import multiprocessing
import pathlib
import random
import select
import socket
import struct
import sys
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path += [str(ROOT / "tests" / "interop"), str(ROOT / "tests" / "support")]
from flat import Schema  # noqa: E402
from served import Served  # noqa: E402
import websocket  # noqa: E402

SCHEMA = Schema((ROOT / "protocol" / "seaway.fbs").read_text())
ALL_FIELDS = 0x1FFF
SURFACE_FIELDS = 63
HOUR_US = 3_600_000_000
ERRORS = {number: name for name, number in SCHEMA.enums["ErrorCode"].items()}


class Peer:
    """A session that never waits: what has come is taken as it comes."""

    def __init__(self, port, receive_buffer=0):
        self.socket = websocket.WebSocket("127.0.0.1", port, "/v1/stream", "seaway.v1")
        self.raw = self.socket.socket
        self.raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.bytes = bytearray(self.socket.received)
        self.state = None
        self.send("Hello", versions=[1], client="load", token="")
        while self.state is None:
            for message in self.take(5):
                if message["kind"] == "SeaState":
                    self.state = message

    def frame(self, payload):
        """Masked with zeros: the load must not cost more than the server."""
        n = len(payload)
        head = (struct.pack(">BB", 0x82, 0x80 | n) if n < 126 else struct.pack(">BBH", 0x82, 0xFE, n) if n < 65536
                else struct.pack(">BBQ", 0x82, 0xFF, n))
        return head + b"\0\0\0\0" + payload

    def send(self, kind, **values):
        self.raw.sendall(self.frame(SCHEMA.write_message(kind, **values)))

    def take(self, wait_s):
        """The messages that have come by then; tiles are read by their head alone."""
        if select.select([self.raw], [], [], wait_s)[0]:
            some = self.raw.recv(1 << 18)
            if not some:
                raise websocket.Closed(None)
            self.bytes += some
        at, messages = 0, []
        view = self.bytes
        while len(view) - at >= 2:
            opcode, n, head = view[at] & 15, view[at + 1] & 127, 2
            if n == 126:
                if len(view) - at < 4:
                    break
                n, head = struct.unpack_from(">H", view, at + 2)[0], 4
            elif n == 127:
                if len(view) - at < 10:
                    break
                n, head = struct.unpack_from(">Q", view, at + 2)[0], 10
            if len(view) - at < head + n:
                break
            payload = bytes(view[at + head:at + head + n])
            at += head + n
            if opcode == 9:
                self.raw.sendall(struct.pack(">BB", 0x8A, 0x80 | len(payload)) + b"\0\0\0\0" + payload)
            elif opcode == 2:
                messages.append(SCHEMA.read_message(payload))
            elif opcode == 8:
                raise websocket.Closed(payload)
        del self.bytes[:at]
        return messages


def query_bytes(request_id, points, exact=False):
    return SCHEMA.write_message("Query", request_id=request_id, exact=exact, points=points)


def random_points(count, times_us):
    return [{"x_m": random.uniform(-5e4, 5e4), "y_m": random.uniform(-5e4, 5e4),
             "time_us": times_us[i % len(times_us)]} for i in range(count)]


def healthy(port, stop, fields, probe, report):
    """Subscribes to all, acknowledges, asks a single point ten times a second."""
    peer = Peer(port)
    peer.send("Subscribe", request_id=1, cascades=0xFFFFFFFF, fields=fields, error_m=0.0, credit=8)
    wanted = None
    parts = collections.defaultdict(set)
    seen = collections.defaultdict(set)
    sea_us, at_s = 0, 0.0
    asked, latencies, refused = {}, [], collections.Counter()
    next_s = time.monotonic() + 1
    peer.send("Ping", request_id=2, client_time_us=0)
    started = False
    number = 100
    while not stop.is_set() or asked:
        now = time.monotonic()
        if stop.is_set() and now > stop_s + 60:
            break
        if not stop.is_set():
            stop_s = now
        if now >= next_s and not stop.is_set() and sea_us:
            next_s = max(next_s + 0.1, now)
            number += 1
            asked[number] = now
            ahead_us = {"now": 0, "far": random.randrange(10 * HOUR_US), "exact": 0}[probe]
            peer.raw.sendall(peer.frame(query_bytes(number, random_points(1, [
                sea_us + int(1e6 * (now - at_s)) + ahead_us]), probe == "exact")))
        for m in peer.take(max(0.0, min(0.05, next_s - time.monotonic()))):
            kind = m["kind"]
            if kind == "Pong":
                sea_us, at_s = m["sea_time_us"], time.monotonic()
            elif kind == "Subscribed":
                wanted = m["fields"]
            elif kind == "FetchDone":
                started = True
            elif kind == "Tile":
                key = (m["cascade"], m["time_us"])
                parts[key].add((m["field"], m["part"]))
                if len(parts[key]) == bin(wanted).count("1") * m["parts"]:
                    del parts[key]
                    peer.send("Ack", keyframe=m["keyframe"])
                    if started:
                        seen[m["cascade"]].add(m["time_us"])
            elif kind == "QueryReply" and m["request_id"] in asked:
                latencies.append((asked[m["request_id"]], time.monotonic() - asked.pop(m["request_id"])))
            elif kind == "Refused":
                if m["request_id"] in asked:
                    asked.pop(m["request_id"])
                refused[f"{ERRORS[m['code']]}: {m['message']}"] += 1
    lost = expected = 0
    for cascade, times in seen.items():
        interval = peer.state["cascades"][cascade]["interval_us"]
        span = (max(times) - min(times)) // interval + 1
        expected += span
        lost += span - len(times)
    report.put({"expected": expected, "lost": lost, "latencies": latencies, "refused": dict(refused),
                "unanswered": len(asked)})


def flood(port, kind, stop, report, seed):
    """One attacking session; reads what it is sent."""
    random.seed(seed)
    counts = collections.Counter()
    peer = Peer(port)
    under_way = 0
    wave = {"fetch": 2, "crowd": 2, "points": 16, "exact": 16}[kind]
    far = lambda: random.randrange(-1000 * HOUR_US, 1000 * HOUR_US)  # noqa: E731
    batches = [peer.frame(query_bytes(i + 1, random_points(4096, [far() for _ in range(8)]) if kind == "points"
                                      else random_points(256, [far() for _ in range(256)]), kind == "exact"))
               for i in range(4)] if kind in ("points", "exact") else None
    pause_s = 0.0
    while not stop.is_set():
        while under_way < wave and time.monotonic() >= pause_s:
            under_way += 1
            if kind == "fetch":
                peer.send("Fetch", request_id=under_way, times_us=[far() for _ in range(8)],
                          cascades=0xFFFFFFFF, fields=ALL_FIELDS, error_m=0.0)
            elif kind == "crowd":
                peer.send("Fetch", request_id=under_way, times_us=[far()], cascades=0xFFFFFFFF,
                          fields=ALL_FIELDS, error_m=0.0)
            else:
                peer.raw.sendall(random.choice(batches))
        for m in peer.take(0.02):
            if m["kind"] == "Refused":
                under_way -= 1
                counts[ERRORS[m["code"]]] += 1
                pause_s = time.monotonic() + 0.01  # hardly polite
            elif m["kind"] in ("FetchDone", "QueryReply"):
                under_way -= 1
                counts["done"] += 1
    peer.raw.close()
    report.put(dict(counts))


def leave(port, stop, report, _):
    """16 sessions after each other send legal queries, 100 MB in all, and go without reading."""
    counts = collections.Counter()
    end_s = time.monotonic() + 20
    sent = 0
    batch = query_bytes(1, random_points(4096, [random.randrange(1000 * HOUR_US) for _ in range(4096)]))
    while sent < 102e6 and time.monotonic() < end_s:
        peer = Peer(port)
        frame = peer.frame(batch)
        for _ in range(16):
            peer.raw.sendall(frame)
            sent += len(frame)
        peer.raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        time.sleep(0.02)
        peer.raw.close()
        counts["sessions"] += 1
    counts["MB"] = int(sent / 1e6)
    report.put(dict(counts))


def unread(port, stop, report, seed):
    """Fetches what one session may have, and reads nothing of it; queries too."""
    random.seed(seed)
    batch = query_bytes(9, random_points(4096, [random.randrange(HOUR_US)]))
    peers = []
    for _ in range(16):
        peer = Peer(port)
        peers.append(peer)
        for i in range(2):
            start = random.randrange(1000 * HOUR_US)
            peer.send("Fetch", request_id=1 + i, times_us=[start + 977_000_000 * k for k in range(8)],
                      cascades=0xFFFFFFFF, fields=0xFFF, error_m=0.0)
        frame = peer.frame(batch)
        for _ in range(16):
            peer.raw.sendall(frame)
    stop.wait()
    report.put({"sessions": len(peers)})


def maps(port, stop, report, seed, slow=False):
    counts = collections.Counter()
    while not stop.is_set():
        try:
            s = socket.create_connection(("127.0.0.1", port), timeout=20)
            s.sendall((f"GET /v1/map?width_m=4096&height_m=4096&columns=4096&rows=4096&t_s={random.randrange(10**6)}"
                       " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").encode())
            head = s.recv(4096)
            counts[head[9:12].decode()] += 1
            while head.startswith(b"HTTP/1.1 200") and not stop.is_set():
                if slow:
                    time.sleep(0.05)
                if not s.recv(1 << 14 if slow else 1 << 18):
                    break
            s.close()
        except OSError as error:
            counts[type(error).__name__] += 1
        if not head.startswith(b"HTTP/1.1 200"):
            time.sleep(0.05)
    report.put(dict(counts))


def memory_mb(pid, what="VmRSS"):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith(what + ":"):
            return int(line.split()[1]) / 1024
    return 0.0


def settled_mb(pid, seconds=10):
    """The mean of some seconds: keyframes come and go in between."""
    looks = []
    for _ in range(2 * seconds):
        looks.append(memory_mb(pid))
        time.sleep(0.5)
    return sum(looks) / len(looks)


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def options():
    parser = argparse.ArgumentParser()
    parser.add_argument("attack")
    parser.add_argument("seconds", nargs="?", type=float, default=20)
    parser.add_argument("--server", default=str(ROOT / "build" / "dev" / "bin" / "seaway-server"))
    parser.add_argument("--scene", default=str(ROOT / "scenes" / "north_sea_gale.toml"))
    parser.add_argument("--device", default="native")
    parser.add_argument("--after", type=float, default=5)
    parser.add_argument("--probe", default="now", choices=["now", "far", "exact"])
    parser.add_argument("--fields", type=lambda text: int(text, 0), default=SURFACE_FIELDS)
    parser.add_argument("--attackers", type=int)
    return parser.parse_args()


def start_attack(asked, port, stop, report):
    how_many = asked.attackers or {"quiet": 0, "crowd": 64, "maps": 8, "slow": 2, "unread": 4}.get(asked.attack, 1)
    work = {"leave": leave, "maps": maps, "slow": maps, "unread": unread}.get(asked.attack, flood)
    attackers = []
    for seed in range(how_many):
        arguments = ((port, asked.attack, stop, report, seed) if work is flood
                     else (port, stop, report, seed) + ((True,) if asked.attack == "slow" else ()))
        attackers.append(multiprocessing.Process(target=work, args=arguments))
        attackers[-1].start()
    return attackers


def cpu_s(pid):
    return sum(map(int, pathlib.Path(f"/proc/{pid}/stat").read_text().split()[13:15])) / 100


def left_out(port):
    text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20).read().decode()
    metrics = dict(line.rsplit(" ", 1) for line in text.splitlines() if line[0] != "#")
    return {name: metrics[f"seaway_{name}"] for name in ("keyframes_skipped_total", "net_keyframes_dropped_total",
                                                          "net_keyframes_replaced_total") if f"seaway_{name}" in metrics}


def say(asked, result, begun_s, ended_s, attack, cores, memory):
    parts = {"before": [s for at, s in result["latencies"] if at < begun_s],
             "during": [s for at, s in result["latencies"] if begun_s <= at < ended_s],
             "after": [s for at, s in result["latencies"] if at >= ended_s]}
    points = "; ".join(f"{when} p50 {1e3 * percentile(some, .5):.1f} p99 {1e3 * percentile(some, .99):.1f} of {len(some)}"
                       for when, some in parts.items())
    print(f"{asked.attack}: lost {result['lost']} of {result['expected']}; single points, ms: {points};"
          f" refused {result['refused']} unanswered {result['unanswered']}; attack {attack}; cores {cores:.2f};"
          f" {memory}", flush=True)


def main():
    asked = options()
    with Served(asked.server, asked.scene, "--device", asked.device) as served:
        port, server = served.port, served.process
        report, attack_report = multiprocessing.Queue(), multiprocessing.Queue()
        stop, stop_attack = multiprocessing.Event(), multiprocessing.Event()
        good = multiprocessing.Process(target=healthy, args=(port, stop, asked.fields, asked.probe, report))
        good.start()
        time.sleep(6)
        idle_mb = settled_mb(server.pid)
        begun_s, busy_s = time.monotonic(), cpu_s(server.pid)
        attackers = start_attack(asked, port, stop_attack, attack_report)
        time.sleep(asked.seconds)
        cores = (cpu_s(server.pid) - busy_s) / asked.seconds
        stop_attack.set()
        ended_s = time.monotonic()
        total = collections.Counter()
        for _ in attackers:
            total.update(attack_report.get(timeout=120))
        time.sleep(asked.after)
        memory = (f"RSS MB alone {idle_mb:.0f} most {memory_mb(server.pid, 'VmHWM'):.0f}"
                  f" after {asked.after:.0f} s {settled_mb(server.pid):.0f}; {left_out(port)}")
        stop.set()
        result = report.get(timeout=120)
        for process in attackers + [good]:
            process.join()
        say(asked, result, begun_s, ended_s, dict(total), cores, memory)


if __name__ == "__main__":
    main()

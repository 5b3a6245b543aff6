#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a gateway would spare and cost: a server that makes its keyframes itself, beside one that would be sent them through NATS.

    gateway_price.py BUILD [SCENE ...]

Of each scene and kind of stream: processor time of a server with one reader, and with nobody; then as many bytes in as many messages through a
nats-server to one to three bare readers, which take them and do nothing: the least that gateways would cost. Printed as a table; docs/decisions
has what followed from it. Ends by itself; run by hand, nothing else running.
"""
import pathlib
import socket
import sys
import tempfile
import threading
import time

from fleet_model import swarm_row
from fleet_processes import Fleet, SOURCE

SECONDS = 20
SCENES = ["scenes/north_sea_gale.toml", "scenes/hurricane.toml", "docs/effects/film_shot.toml"]
READERS = [1, 3]
PAYLOAD_MOST = 512 * 1024  # of one message; NATS takes a megabyte unless told otherwise


def cpu_s(who):
    """Of the threads of a folder in /proc."""
    return sum(1e-9 * int((task / "schedstat").read_text().split()[0]) for task in who)


def threads_of(pid):
    return list(pathlib.Path(f"/proc/{pid}/task").iterdir())


def connect(port):
    line = socket.create_connection(("127.0.0.1", port))
    line.recv(4096)  # INFO
    line.sendall(b'CONNECT {"verbose":false}\r\n')
    return line


class Reader(threading.Thread):
    """Takes bytes as cheaply as can be, and answers pings of NATS."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.line = connect(port)
        self.line.sendall(b"SUB seaway.price 1\r\nPING\r\n")
        self.count = 0
        self.start()

    def run(self):
        room = bytearray(1 << 20)
        self.who = [pathlib.Path(f"/proc/self/task/{threading.get_native_id()}")]
        while True:
            count = self.line.recv_into(room)
            if count == 0:
                return
            self.count += count


def through_nats(fleet, bytes_a_s, messages_a_s, readers):
    """Cores of nats-server, and of each reader."""
    fleet.start("nats", "/usr/sbin/nats-server", "-a", "127.0.0.1", "-p", fleet.nats_port)
    fleet.wait_for(lambda: fleet.listens(fleet.nats_port), "NATS")
    try:
        pid = fleet.processes["nats"].pid
        there = [Reader(fleet.nats_port) for _ in range(readers)]
        line = connect(fleet.nats_port)
        size = int(bytes_a_s / messages_a_s)
        pieces = [min(PAYLOAD_MOST, size - at) for at in range(0, size, PAYLOAD_MOST)]
        time.sleep(0.5)
        before, began = [cpu_s(threads_of(pid)), *(cpu_s(reader.who) for reader in there)], time.monotonic()
        sent = 0
        while (now := time.monotonic() - began) < SECONDS:
            while sent < now * messages_a_s:
                line.sendall(b"".join(b"PUB seaway.price %d\r\n%b\r\n" % (piece, bytes(piece)) for piece in pieces))
                sent += 1
            time.sleep(0.01)
        after = [cpu_s(threads_of(pid)), *(cpu_s(reader.who) for reader in there)]
        if min(reader.count for reader in there) < 0.95 * sent * size:
            raise RuntimeError("readers were left behind")
        used = [(b - a) / SECONDS for a, b in zip(before, after)]
        return used[0], sum(used[1:]) / readers
    finally:
        fleet.stop("nats")


def of_server(fleet, scene, words, readers):
    fleet.scene = SOURCE / scene
    fleet.start_server("a", False, "--request-bytes-per-address", 0)
    fleet.wait_for(lambda: fleet.ready("a"), "the server", 120)
    try:
        return swarm_row(fleet, "a", ["--clients", readers, "--askers", 0, "--seconds", SECONDS, "--warm-up", 5, *words])
    finally:
        fleet.stop("a")


def main():
    build, scenes = sys.argv[1], sys.argv[2:] or SCENES
    print("scene,stream,keyframes_a_s,mbit_a_s,cores_made,cores_there,readers,nats_cores,reader_cores", flush=True)
    with tempfile.TemporaryDirectory(prefix="seaway-gateway-") as folder:
        fleet = Fleet(build, folder)
        try:
            for scene in scenes:
                there = float(of_server(fleet, scene, ["--fields", "none"], 1)["cpu_cores"])
                for kind, words in (("six fields, predicted", ["--fields", "surface", "--predicted"]), ("all fields, whole", ["--fields", "all"])):
                    row = of_server(fleet, scene, words, 1)
                    rate, size = float(row["keyframes_a_s"]), 1e3 * float(row["kb_a_keyframe"])
                    for readers in READERS:
                        nats, reader = through_nats(fleet, rate * size, rate, readers)
                        print(f"{scene},{kind},{rate:.2f},{8e-6 * rate * size:.3f},{row['cpu_cores']},{there:.4f},{readers},{nats:.4f},{reader:.4f}",
                              flush=True)
        finally:
            fleet.stop_all()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What a crowd of one address does to its neighbours: figures for docs/operations.md, no judgement.

    tests/load/door_crowd.py build/dev/bin/seaway-server [CONNECTIONS [SECONDS]]

Three crowds, each against a server of its own (scenes/calm.toml, native): CONNECTIONS sockets of 127.0.0.1
that say nothing, send half a request, or upgrade and say no Hello, and come again as often as they are
closed. Beside each, from 127.0.0.2, twice a second: a health probe, an upgrade, and a probe of
--health-listen; one connection that was idle between two requests when the crowd came; and a client that
had subscribed before and asks ten times a second (tests/interop).
"""
import functools
import pathlib
import select
import socket
import subprocess
import sys
import time

from fleet_processes import free_port

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tests/interop"), str(ROOT / "tests/support")]
import client  # noqa: E402
from served import Served  # noqa: E402

CROWD, NEIGHBOUR = "127.0.0.1", "127.0.0.2"
GET = b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
UPGRADE = (b"GET /v1/stream HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
           b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
           b"Sec-WebSocket-Protocol: seaway.v1\r\n\r\n")
CROWDS = {"silent": b"", "half a request": b"GET /heal", "no Hello": UPGRADE}


def connected(source, port):
    one = socket.socket()
    one.settimeout(5)
    one.bind((source, 0))
    one.connect(("127.0.0.1", port))
    return one


def asked(source, port, request):
    """Status, or what went wrong, and milliseconds."""
    begun = time.monotonic()
    try:
        with connected(source, port) as one:
            one.sendall(request)
            answer = one.recv(4096)
            status = answer.split()[1].decode() if answer else "closed"
    except OSError as error:
        status = type(error).__name__
    return status, 1e3 * (time.monotonic() - begun)


class Crowd:
    def __init__(self, port, size, says):
        self.port, self.size, self.says = port, size, says
        self.sockets, self.poll, self.closed = {}, select.poll(), 0

    def keep_up(self):
        for _ in range(self.size - len(self.sockets)):
            try:
                one = connected(CROWD, self.port)
                one.sendall(self.says)
            except OSError:
                break
            self.sockets[one.fileno()] = one
            self.poll.register(one, select.POLLIN)
        for number, _ in self.poll.poll(10):
            try:
                if self.sockets[number].recv(4096):
                    continue
            except OSError:
                pass
            self.poll.unregister(number)
            self.sockets.pop(number).close()
            self.closed += 1


def summary(answers):
    good = [ms for status, ms in answers if status in ("200", "101")]
    worst = f", at most {max(good):.0f} ms" if good else ""
    others = sorted({status for status, _ in answers} - {"200", "101"})
    return f"{len(good)} of {len(answers)}{worst}" + (f" ({', '.join(others)})" if others else "")


def subscribed(port, seconds):
    """A client in a process of its own: keyframes it misses, and how long its queries take."""
    socket.create_connection = functools.partial(socket.create_connection, source_address=(NEIGHBOUR, 0))
    session = client.Session("127.0.0.1", port)
    session.subscribe()
    took_ms, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        begun = time.monotonic()
        session.query([(1.0, 2.0, session.sea_time_us())])
        took_ms.append(1e3 * (time.monotonic() - begun))
        time.sleep(0.1)
    missed = 0
    for epoch, cascade in {key[:2] for key in session.keyframes}:
        times = sorted(key[2] for key in session.keyframes if key[:2] == (epoch, cascade))
        interval = session.states[epoch]["cascades"][cascade]["interval_us"]
        missed += (times[-1] - times[0]) // interval + 1 - len(times)
    took_ms.sort()
    print(f"missed {missed} of {len(session.keyframes)} keyframes, ping and query {took_ms[len(took_ms) // 2]:.1f} ms, "
          f"at most {took_ms[-1]:.0f}")


def run(server, size, seconds, name):
    health = free_port()
    served = Served(server, ROOT / "scenes/calm.toml", "--device", "native", "--health-listen", f"127.0.0.1:{health}",
                    stderr=subprocess.PIPE)
    port = served.port
    try:
        idle = connected(NEIGHBOUR, port)
        idle.sendall(GET)
        idle.recv(4096)
        healthy = subprocess.Popen([sys.executable, "-B", __file__, "--subscribed", str(port), str(seconds + 1)],
                                   stdout=subprocess.PIPE, text=True)
        time.sleep(1)
        crowd = Crowd(port, size, CROWDS[name])
        probes, upgrades, healths = [], [], []
        end, due = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            crowd.keep_up()
            if time.monotonic() >= due:
                due = time.monotonic() + 0.5
                probes.append(asked(NEIGHBOUR, port, GET))
                upgrades.append(asked(NEIGHBOUR, port, UPGRADE))
                healths.append(asked(NEIGHBOUR, health, GET))
        try:
            idle.sendall(GET)
            stays = "stays" if idle.recv(4096) else "was closed"
        except OSError:
            stays = "was closed"
        held, fared = len(crowd.sockets), healthy.communicate()[0].strip()
    finally:
        log = served.stop().splitlines()
    crowded = sum("event=connections_crowded" in line for line in log)
    print(f"{name}: probes {summary(probes)}; upgrades {summary(upgrades)}; health listener {summary(healths)}; "
          f"idle connection {stays}; crowd closed {crowd.closed} times, {held} open; log {len(log)} lines, "
          f"{crowded} of crowding; subscriber {fared}")


def main():
    if sys.argv[1] == "--subscribed":
        return subscribed(int(sys.argv[2]), float(sys.argv[3]))
    size = int(sys.argv[2]) if len(sys.argv) > 2 else 1280
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 8.0
    for name in CROWDS:
        run(sys.argv[1], size, seconds, name)
    return None


if __name__ == "__main__":
    main()

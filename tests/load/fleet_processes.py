# SPDX-License-Identifier: Apache-2.0
"""The processes of a fleet on loopback, each on a port of its own: nats-server, seaway-servers, a line that can be cut between one of
them and NATS, and HAProxy, with the configuration of deploy/fleet."""

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
import threading
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(SOURCE / "tests/support"))
from certificate import make_certificate  # noqa: E402

SCENE = SOURCE / "scenes/calm.toml"
WORLD = "north-sea"
TOKEN = "fleet-of-the-test"


PORTS = list(range(12_000, 32_000))
random.SystemRandom().shuffle(PORTS)


def free_port():
    """One that nobody listens on now, given once, and that stays free until somebody is started on it, or started again: below those that
    the system gives to who connects (from 32768), of which one may be the other end of a connection by then."""
    while True:
        port = PORTS.pop()
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass


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
        make_certificate(self.certificate, self.key)
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
        if os.geteuid() != 0:  # who is not root cannot become another
            text = re.sub(r"\n    (?:user|group|chroot) .*", "", text)
        text = text.replace("maxconn 20000", "maxconn 1000")  # as few open files as a test may have
        text = text.replace("bind :443", f"bind 127.0.0.1:{self.balancer_port}")
        for name in self.names:
            port, health = self.ports[name]
            there = "" if name in names else " disabled"
            text = re.sub(rf"server {name} .*", f"server {name} 127.0.0.1:{port} port {health}{there}", text)
        config = self.folder / file
        config.write_text(text)
        self.start("haproxy", "/usr/sbin/haproxy", "-f", config)
        self.wait_for(self.balanced, "HAProxy")

    def balanced(self):
        """HAProxy takes clients, and questions of its operator: it opens the one before the other."""
        try:
            return self.listens(self.balancer_port) and bool(self.ask_balancer("show info"))
        except OSError:
            return False

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

    def wait_for(self, condition, what, limit_s=60):
        until = time.monotonic() + limit_s
        while not condition():
            for name, process in list(self.processes.items()):  # threads of their own start and stop others meanwhile
                if process.poll() is not None and self.processes.get(name) is process:
                    raise RuntimeError(f"{name} ended with {process.returncode} before {what}:\n{self.last_words(name)}")
            if time.monotonic() > until:
                raise RuntimeError(f"{what} took longer than {limit_s} s\n" + "\n".join(map(self.last_words, list(self.processes))))
            time.sleep(0.02)

    def last_words(self, name):
        lines = (self.folder / f"{name}.log").read_text(errors="replace").splitlines()
        return "\n".join(f"{name}: {line}" for line in lines[-10:])

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

    def state(self, name):
        """Of a server that answers, however long a busy machine takes."""
        bodies = []

        def answers():
            bodies.append(self.page(name, "/v1/state")[1])
            return bodies[-1]
        self.wait_for(answers, f"the state of {name}")
        return json.loads(bodies[-1])

    def ready(self, name):
        return name in self.processes and self.page(name, "/readyz")[0] == 200

    def change(self, name, wind_mps):
        """What seaway-ctl says: the promise, or None."""
        said = subprocess.run([self.bin / "seaway-ctl", f"ws://127.0.0.1:{self.ports[name][0]}", "--token-file",
                               self.folder / "admin.token", "--timeout", "8", "set",
                               f"systems.0.wind_speed_10m_mps={wind_mps:.2f}", "--over", "10s"],
                              capture_output=True, text=True, check=False)
        return json.loads(said.stdout) if said.returncode == 0 else None

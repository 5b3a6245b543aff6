#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The files of deploy/fleet are what the programs that read them take, and name options that the server has.

    test_deploy.py BUILD
"""

import configparser
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import yaml

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(SOURCE / "tests/support"))
from certificate import make_certificate  # noqa: E402

FLEET = SOURCE / "deploy/fleet"
SERVER = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else SOURCE / "build/dev").resolve() / "bin/seaway-server"


def run(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, cwd=SOURCE)


def options_of_the_server():
    return set(re.findall(r"(--[a-z][a-z-]+)", run(SERVER, "--help").stdout))


def options_in(words):
    return {word.split("=")[0] for word in words if word.startswith("--")}


class Deploy(unittest.TestCase):
    def test_haproxy_takes_each_of_its_configurations(self):
        with tempfile.TemporaryDirectory() as folder:
            make_certificate(f"{folder}/cert", f"{folder}/key")
            (pathlib.Path(folder) / "sea.pem").write_text(
                (pathlib.Path(folder) / "cert").read_text() + (pathlib.Path(folder) / "key").read_text())
            for name in ("haproxy.cfg", "haproxy-passthrough.cfg", "compose-haproxy.cfg"):
                text = (FLEET / name).read_text()
                # Names that only the operator's network knows.
                text = re.sub(r"sea-[abc](\.example\.org)?:", "127.0.0.1:", text)
                text = text.replace("/etc/haproxy/sea.pem", f"{folder}/sea.pem")
                text = text.replace("/run/haproxy/seaway.sock", f"{folder}/sock")
                for wrong in ("", "\nbackend certain\n    balnace leastconn\n"):
                    config = pathlib.Path(folder) / name
                    config.write_text(text + wrong)
                    checked = run("/usr/sbin/haproxy", "-c", "-f", config)
                    self.assertEqual(checked.returncode == 0, wrong == "", name + checked.stderr)
                if not name.startswith("compose"):  # that image is not root's
                    self.assertIn("\n    user haproxy\n", text, name)
                self.assertIn("GET /readyz", text)
                self.assertIn("GET /healthz", text)
                # Sessions of a server that hangs end; those of one that is only in doubt do not.
                self.assertEqual(text.count("on-marked-down shutdown-sessions"), 2, name)
                self.assertIn("expect error-status L7OKC status 200", text.split("\nbackend alive\n")[0], name)
                self.assertNotIn("L7OKC", text.split("\nbackend alive\n")[1], name)
                self.assertIn("hard-stop-after", text, name)

    def test_haproxy_has_room_for_the_sessions_of_the_servers_and_so_it_has_with_what_larger_ones_are_told(self):
        said = run(SERVER, "--help").stdout
        shipped = [int(re.search(rf"--{name}-max COUNT:INT in \[.*?\](?:=| \[)(\d+)", said)[1]) for name in ("sessions", "connections")]
        text = (FLEET / "fleet.toml").read_text()
        larger = [int(re.search(rf"\n# {name}-max = (\d+)\n", text)[1]) for name in ("sessions", "connections")]
        for name in ("haproxy.cfg", "haproxy-passthrough.cfg", "compose-haproxy.cfg"):
            balancer = (FLEET / name).read_text()
            each = re.findall(r"default-server .* maxconn (\d+)", balancer)
            self.assertEqual(len(each), 2, "both backends")
            # A server that has all its sessions still answers pages, and says itself that it is full.
            for limit in map(int, each):
                self.assertTrue(shipped[0] < limit < shipped[1], f"{name}: {limit} beside {shipped}")
            told = int(re.search(r"# maxconn, here and below: .* (\d+) with those of the comments in fleet.toml", balancer)[1])
            self.assertTrue(larger[0] < told < larger[1], f"{name}: {told} beside {larger}")
            self.assertGreaterEqual(int(re.search(r"\n    maxconn (\d+)", balancer)[1]), 3 * max(*map(int, each), told), f"{name}: of all servers")
        kubernetes = (FLEET / "kubernetes.yaml").read_text()
        for option, count in zip(("sessions", "connections"), larger):
            self.assertIn(f"# - --{option}-max={count}\n", kubernetes)
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(re.sub(r"\n# (\w+-max = )", r"\n\1", text))
            file.flush()
            checked = run(SERVER, "scenes/calm.toml", "--config", file.name, "--check")
            self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_nats_takes_its_configuration(self):
        good = run("/usr/sbin/nats-server", "-t", "-c", FLEET / "nats.conf")
        self.assertEqual(good.returncode, 0, good.stderr)
        with tempfile.TemporaryDirectory() as folder:
            make_certificate(f"{folder}/nats-a.pem", f"{folder}/nats-a.key", "nats-a")
            text = (FLEET / "nats.conf").read_text().replace("/etc/nats/ca.pem", f"{folder}/nats-a.pem")
            text, guarded = re.subn(r"# (authorization|tls):", r"\1:", text.replace("/etc/nats/", f"{folder}/"))
            self.assertEqual(guarded, 3, "routes and clients")
            config = pathlib.Path(folder) / "nats.conf"
            config.write_text(text)
            checked = run("/usr/sbin/nats-server", "-t", "-c", config)
            self.assertEqual(checked.returncode, 0, "with what is for outside a private network: " + checked.stderr)
        with tempfile.NamedTemporaryFile("w", suffix=".conf") as file:
            file.write((FLEET / "nats.conf").read_text() + "\nno_such_key: [ {\n")
            file.flush()
            self.assertNotEqual(run("/usr/sbin/nats-server", "-t", "-c", file.name).returncode, 0)

    def test_the_server_takes_the_options_of_the_fleet(self):
        checked = run(SERVER, "scenes/calm.toml", "--config", FLEET / "fleet.toml", "--check")
        self.assertEqual(checked.returncode, 0, checked.stderr)
        unit = configparser.ConfigParser(strict=False, interpolation=None)
        unit.optionxform = str
        unit.read(FLEET / "seaway-fleet@.service")
        start = unit["Service"]["ExecStart"]
        self.assertEqual(unit["Service"]["RestartPreventExitStatus"], "2", "and not 5: NATS is away")
        self.assertLessEqual(options_in(start.split()), options_of_the_server())
        self.assertIn("%i", unit["Service"]["EnvironmentFile"])
        for variable in re.findall(r"\$\{(\w+)\}", start):
            self.assertIn(f"{variable}=", (FLEET / "seaway-fleet@.service").read_text().split("[Unit]")[0])

    def test_units_start_again_what_passes_and_nothing_else(self):
        for path in (FLEET / "seaway-fleet@.service", SOURCE / "deploy/seaway-server.service"):
            unit = configparser.ConfigParser(strict=False, interpolation=None)
            unit.optionxform = str
            unit.read(path)
            service = unit["Service"]
            self.assertEqual(service["Restart"], "on-failure", path)
            self.assertEqual(service["RestartPreventExitStatus"], "2", path)
            # systemd asks RestartPreventExitStatus= of the main process alone: what fails before it is started again for ever.
            self.assertNotIn("ExecStartPre", service, path)
            cache = service["CacheDirectory"]
            self.assertEqual(service["Environment"], f"XDG_CACHE_HOME=%C/{cache}", "kernels that were measured are remembered")
            self.assertEqual(unit["Unit"]["StartLimitIntervalSec"], "0", "NATS may be away for as long as it takes")
            # Sea time is UTC. Who sets the clock pulls that target in, not who wants it right: systemd.special(7).
            self.assertIn("time-sync.target", unit["Unit"]["After"].split(), path)
            self.assertNotIn("time-sync.target", unit["Unit"]["Wants"].split(), path)
        # What the main process ends with.
        wrong = run(SERVER, "scenes/calm.toml", "--listen", "nowhere")
        self.assertEqual(wrong.returncode, 2, wrong.stderr)
        away = run(SERVER, "scenes/calm.toml", "--listen", "127.0.0.1:0", "--device", "native",
                   "--journal", "nats://127.0.0.1:1/away")
        self.assertEqual(away.returncode, 5, away.stderr)

    def test_compose_names_what_is_there_and_options_that_are(self):
        whole = yaml.safe_load((FLEET / "compose.yaml").read_text())
        services = whole["services"]
        servers = [service for name, service in services.items() if name.startswith("sea-")]
        self.assertEqual(len(servers), 3)
        for server in servers:
            self.assertLessEqual(options_in(server["command"]), options_of_the_server())
            self.assertTrue(set(server["depends_on"]) <= set(services))
        balancer = (FLEET / "compose-haproxy.cfg").read_text()
        for name in services:
            if name.startswith("sea-"):
                self.assertIn(f" {name}:9430", balancer)
        self.assertTrue((FLEET / servers[0]["build"] / "Dockerfile").is_file())

    def test_kubernetes_objects_hang_together(self):
        objects = {one["kind"]: one for one in yaml.safe_load_all((FLEET / "kubernetes.yaml").read_text())}
        self.assertEqual(set(objects), {"Deployment", "Service", "PodDisruptionBudget"})
        spec = objects["Deployment"]["spec"]
        labels = spec["template"]["metadata"]["labels"]
        for selector in (spec["selector"]["matchLabels"], objects["Service"]["spec"]["selector"],
                         objects["PodDisruptionBudget"]["spec"]["selector"]["matchLabels"]):
            self.assertEqual(selector, labels)
        server = spec["template"]["spec"]["containers"][0]
        self.assertLessEqual(options_in(server["args"]), options_of_the_server())
        ports = {port["name"]: port["containerPort"] for port in server["ports"]}
        for option, port in (("--listen", "sea"), ("--health-listen", "health")):
            self.assertIn(f"{option}=0.0.0.0:{ports[port]}", server["args"])
        self.assertEqual(server["livenessProbe"]["httpGet"]["path"], "/healthz")
        self.assertEqual(server["readinessProbe"]["httpGet"]["path"], "/readyz")
        volumes = {volume["name"] for volume in spec["template"]["spec"]["volumes"]}
        self.assertEqual({mount["name"] for mount in server["volumeMounts"]}, volumes)
        # The drain, and what a process that hangs takes to end by itself.
        self.assertGreater(spec["template"]["spec"]["terminationGracePeriodSeconds"], 2 + 8)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A client that knows docs/protocol.md and the schema alone agrees with the server.

    tests/interop/test_interop.py SEAWAY_SERVER [unittest's options]
"""
import contextlib
import http.client
import pathlib
import random
import socket
import struct
import sys
import unittest

import numpy as np

import client
import surface
import tiles
import websocket

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "support"))
from served import Served  # noqa: E402

GOLDEN = HERE.parent / "golden"
SERVER = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else None
FOLDED = 1


def read_golden(path):
    """(bytes, lines after "says")."""
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    says = lines.index("says")
    return bytes.fromhex(" ".join(lines[:says])), lines[says + 1:]


def values_of(value, path):
    """{"body.points.0.x_m": 1.5}: every value of a message by its place."""
    if isinstance(value, dict):
        children = value.items()
    elif isinstance(value, (list, bytes)):
        children = enumerate(value)
    else:
        return {} if value is None else {path: value}
    return {place: leaf for name, child in children for place, leaf in values_of(child, f"{path}.{name}").items()}


# Of the difference among the golden tiles (tests/protocol/test_golden.cpp).
GOLDEN_EXPECTED = np.array([[0.5, 0.9, 1.5, 1.7], [0.1, 0.5, 0.625, 1.5], [0.5, 1.0, 1.75, -2.0]], np.float32)


class Golden(unittest.TestCase):
    def test_every_golden_message_says_what_its_bytes_mean(self):
        paths = sorted((GOLDEN / "wire_v1").glob("*.txt"))
        self.assertEqual(len(paths), len(client.SCHEMA.bodies) - 1)
        for path in paths:
            data, says = read_golden(path)
            message = client.SCHEMA.read_message(data)
            self.assertEqual(message.pop("kind"), path.stem)
            mine = {k: v for k, v in values_of(message, "body").items()}
            for line in says[1:]:
                place, text = line.split(" = ", 1)
                value = mine[place]
                if isinstance(value, str):
                    self.assertEqual(text, '"' + value.replace("\n", "\\n") + '"', place)
                elif isinstance(value, bool):
                    self.assertEqual(text, str(value).lower(), place)
                else:  # a float32 is written with the digits that tell it from its neighbours
                    self.assertTrue(float(text) == value or np.float32(float(text)) == np.float32(value), line)

    def test_what_is_written_reads_back_the_same(self):
        for path in sorted((GOLDEN / "wire_v1").glob("*.txt")):
            message = client.SCHEMA.read_message(read_golden(path)[0])
            kind = message.pop("kind")
            if any(isinstance(v, dict) or (isinstance(v, list) and v and isinstance(v[0], str))
                   for v in message.values()):
                continue  # only a server writes structs in tables, and lists of strings
            again = client.SCHEMA.read_message(client.SCHEMA.write_message(kind, **message))
            self.assertEqual(again.pop("kind"), kind)
            self.assertEqual(again, message)

    def test_golden_tiles_decode_to_the_same_floats(self):
        for path in sorted((GOLDEN / "tile_codec_v1").glob("*.txt")):
            data, says = read_golden(path)
            bits = tiles.decode(data, GOLDEN_EXPECTED).ravel().view(np.uint32)
            self.assertEqual([f"{b:08x}" for b in bits], says, path.name)


    def test_a_difference_to_something_else_says_so(self):
        data, _ = read_golden(GOLDEN / "tile_codec_v1" / "difference.txt")
        with self.assertRaises(ValueError):
            tiles.decode(data, GOLDEN_EXPECTED + np.float32(0.1))


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Served(SERVER, HERE / "sea.toml", "--device", "native")
        cls.host, cls.port = "127.0.0.1", cls.server.port
        cls.session = client.Session(cls.host, cls.port)

    @classmethod
    def tearDownClass(cls):
        cls.session.socket.close()
        cls.server.stop()

    def http(self, method, path):
        """(status, the header Allow, body)."""
        with contextlib.closing(http.client.HTTPConnection(self.host, self.port)) as connection:
            connection.request(method, path)
            response = connection.getresponse()
            return response.status, response.getheader("Allow"), response.read()

    def compare(self, times_us, count, session=None, slopes=True, error_m=0.02):
        """Own heights against the server's and against the direct sum, within the stated bounds."""
        random.seed(3)
        session, compared = session or self.session, 0
        for time_us in times_us:
            sea = session.surface(time_us)
            places = [(random.uniform(-5000, 5000), random.uniform(-5000, 5000)) for _ in range(count)]
            points = [(x, y, time_us) for x, y in places]
            for (x, y), theirs, exact in zip(places, session.query(points), session.query(points, exact=True)):
                mine = sea.answer(x, y)
                if mine["folded"] or (theirs["flags"] | exact["flags"]) & FOLDED:
                    continue
                self.assertLessEqual(abs(mine["height_m"] - theirs["height_m"]), mine["error_m"] + theirs["error_m"])
                self.assertLessEqual(abs(mine["height_m"] - exact["height_m"]), mine["error_m"] + exact["error_m"])
                self.assertEqual(exact["flags"], 16)
                # Slopes carry the codec's bound of a height over a grid spacing, which is a few mm
                # over the 0.6 m of the finest tile; velocities carry the rates' bounds, some cm/s, which go as those of heights.
                for index, axis in enumerate("xyz" if slopes else ""):
                    self.assertAlmostEqual(mine["normal"][index], theirs["normal_" + axis], delta=0.05)
                    self.assertAlmostEqual(mine["velocity_mps"][index], theirs[f"velocity_{axis}_mps"],
                                           delta=7.5 * error_m)
                compared += 1
        self.assertGreaterEqual(compared, 0.9 * count * len(times_us), "hardly anything folds in this sea")

    def test_water_below_goes_on_from_the_surface_and_ends_at_no_surface(self):
        now_us = self.session.sea_time_us()
        places = [(31.0 * n, -17.0 * n) for n in range(20)]
        exact = self.session.query([(x, y, now_us) for x, y in places], exact=True)
        at_surface = [(x, y, now_us, answer["height_m"]) for (x, y), answer in zip(places, exact)]
        answers, below = self.session.query_below(at_surface)
        for surface, answer, water in zip(exact, answers, below):
            self.assertEqual(surface["height_m"], answer["height_m"])
            self.assertEqual(answer["flags"], 16)
            for axis in "xyz":  # floats on the wire
                self.assertAlmostEqual(water[f"velocity_{axis}_mps"], surface[f"velocity_{axis}_mps"], delta=1e-5)
            # g eta; surface tension adds some hundredths of the shortest waves' share.
            self.assertAlmostEqual(water["pressure_m2ps2"], 9.80665 * answer["height_m"], delta=0.05)
        answers, below = self.session.query_below([(0.0, 0.0, now_us, 1000.0), (0.0, 0.0, now_us, -1000.0)])
        self.assertEqual([answer["flags"] for answer in answers], [16 + 256, 16])
        self.assertEqual(below[0]["pressure_m2ps2"], 0.0)
        self.assertLess(abs(below[1]["pressure_m2ps2"]), 1e-3)
        longer = self.session.query([(x, y, now_us) for x, y in places], min_wavelength_m=1e6)
        whole = self.session.query([(x, y, now_us) for x, y in places])
        self.assertNotEqual([answer["height_m"] for answer in longer], [answer["height_m"] for answer in whole])

    def test_probes_are_the_sea_at_undisplaced_places(self):
        state = self.session.state_at(0)
        self.assertEqual(len(state["probes"]), 16)
        times_us = [probe["time_us"] for probe in state["probes"]]
        self.session.fetch(times_us[:8])
        self.session.fetch(times_us[8:])
        for probe in state["probes"]:
            sea = self.session.surface(probe["time_us"])
            height, dx, dy = sea.at(probe["x_m"], probe["y_m"])[0]
            # Displacements have as much of the bound as heights have: half of the variance each in deep water.
            bound = sea.bound(0, (probe["x_m"], probe["y_m"]), 0) + state["probe_error_m"]
            self.assertLessEqual(abs(height - probe["height_m"]), bound)
            self.assertLessEqual(abs(dx - probe["displacement_x_m"]), bound)
            self.assertLessEqual(abs(dy - probe["displacement_y_m"]), bound)

    def test_a_sea_made_of_its_waves_meets_the_probes_within_the_bound_that_was_granted(self):
        session = client.Session(self.host, self.port)
        granted = session.subscribe_spectrum(error_m=0.02, slope_error=0.01, fields=1 | 1 << surface.FOAM)
        self.assertAlmostEqual(granted["error_m"], 0.02)
        self.assertEqual(granted["fields"], 1)
        self.assertIn("foam", granted["why"])
        (epoch, waves), = session.spectra.items()
        state = session.states[epoch]
        bound = granted["error_m"] + state["probe_error_m"]
        sideways = 5 * waves.left_displacement_m + state["probe_error_m"]
        self.assertLessEqual(6 * waves.left_m, granted["error_m"])
        for probe in state["probes"]:
            height, dx, dy = waves.at(probe["x_m"], probe["y_m"], probe["time_us"])
            self.assertLessEqual(abs(height - probe["height_m"]), bound)
            self.assertLessEqual(abs(dx - probe["displacement_x_m"]), sideways)
            self.assertLessEqual(abs(dy - probe["displacement_y_m"]), sideways)
        session.socket.close()

    def test_heights_of_the_stream_are_the_servers(self):
        granted = self.session.subscribe(error_m=0.02)
        self.assertEqual(granted["fields"], client.SURFACE_FIELDS)
        begin_us = self.session.sea_time_us()
        times_us = []
        while len(times_us) < 3:  # the present, and two moments that only the stream can bring
            now_us = self.session.sea_time_us() - 1_000_000
            if now_us > begin_us + 2_500_000 * len(times_us) and self.session.pairs(now_us):
                times_us.append(now_us)
        self.session.send("Unsubscribe")
        self.compare(times_us, 12)

    def test_heights_of_the_past_and_the_future_are_the_servers(self):
        times_us = [-987_654_321, 0, 3_600_000_000 + 1, 86_400_000_000 * 365 + 123_457]
        done = self.session.fetch(times_us, error_m=0.02)
        self.assertEqual(done["fields"], client.SURFACE_FIELDS)
        self.compare(times_us, 12)

    def test_heights_of_compact_maps_are_the_servers(self):
        session = client.Session(self.host, self.port, compact=True)
        for error_m in (0.02, 0.05):  # two rungs
            session.keyframes.clear()
            done = session.fetch([5_000_001, 86_400_000_000], error_m=error_m)
            self.assertEqual(done["fields"], client.SURFACE_FIELDS)
            held = session.keyframes.values()
            # Bands of the long tiles end far below what their grids hold; that of the last one at 0.6 of it.
            self.assertTrue(all(k.compact_size and k.compact_size <= 0.7 * k.size for k in held))
            # Displacements and their rates were not sent: they follow from heights and theirs.
            self.assertTrue(all(sorted(k.gains) == [1, 2, 4, 5] for k in held))
            self.compare([5_000_001, 86_400_000_000], 12, session, error_m=error_m)
        session.socket.close()

    def test_heights_of_smaller_maps_and_fewer_keyframes_are_the_servers_within_what_they_state(self):
        for compact, size_max, rate_hz_max in ((True, 32, 0), (False, 64, 0), (True, 0, 2), (False, 32, 2)):
            session = client.Session(self.host, self.port, compact=compact)
            granted = session.subscribe(error_m=0.02, size_max=size_max, rate_hz_max=rate_hz_max)
            self.assertEqual(granted["fields"], client.SURFACE_FIELDS)
            if granted["error_m"] > 0.0201:  # else a smaller grid still has all waves
                self.assertIn("heights within", granted["why"])
            self.assertLessEqual(granted["limits"]["size"], size_max)
            self.assertLessEqual(granted["limits"]["rate_hz"], rate_hz_max)
            while not session.pairs(now_us := session.sea_time_us()):
                session.receive()
            if size_max:
                self.assertTrue(all(k.compact_size <= size_max for k in session.keyframes.values() if k.compact_size))
            self.compare([now_us], 24, session, slopes=False)
            session.socket.close()
        with self.assertRaises(client.Refused) as refused:
            self.session.subscribe(rate_hz_max=1)
        self.assertEqual(refused.exception.code, client.SCHEMA.enums["ErrorCode"]["not_offered"])
        self.assertIn("rate_hz_max", str(refused.exception))

    def test_a_bulk_map_is_what_the_client_samples(self):
        self.session.fetch([7_000_000], error_m=0.02)
        sea = self.session.surface(7_000_000)
        _, _, data = self.http("GET", "/v1/map?kind=height&x0_m=-50&y0_m=20&width_m=400&height_m=300&columns=4&rows=3&t_s=7")
        (magic, version, kind, columns, rows, floats, error_m, x0, y0, width, height,
         time_us) = struct.unpack_from("<4sHHIIIf4dq", data)
        self.assertEqual((magic, version, kind, columns, rows, floats, time_us), (b"SWMP", 1, 0, 4, 3, 1, 7_000_000))
        values = np.frombuffer(data, "<f4", offset=64).reshape(rows, columns)
        for j in range(rows):
            for i in range(columns):
                mine = sea.answer(x0 + i * width / columns, y0 + j * height / rows)
                if not mine["folded"]:
                    self.assertLessEqual(abs(values[j, i] - mine["height_m"]), mine["error_m"] + error_m)

    def test_foam_is_a_share_that_is_the_mean_on_average(self):
        time_us = 30_000_000
        self.session.fetch([time_us], fields=client.SURFACE_FIELDS | 1 << surface.FOAM)
        state, pairs = self.session.state_at(time_us), self.session.pairs(time_us)
        self.assertGreater(state["foam_mean"], 0)
        random.seed(5)
        shares = [surface.foam(state, pairs, time_us, np.array([random.uniform(-1e4, 1e4), random.uniform(-1e4, 1e4)]))
                  for _ in range(3000)]
        self.assertTrue(all(0 <= share <= 1 for share in shares))
        # Its scatter is a few times its mean, 3000 places and one moment: within a factor of two.
        self.assertLess(abs(np.log(np.mean(shares) / state["foam_mean"])), np.log(2))

    def test_points_that_are_no_numbers_and_too_many_points_and_fields_that_are_not_there(self):
        self.assertEqual(self.session.query([(float("nan"), 0.0, 0)])[0]["flags"], 8)
        for kind, reply, values, code in (
                ("Query", "QueryReply", {"points": [{"x_m": 0.0, "y_m": 0.0, "time_us": 0}] * 4097}, "too_many_points"),
                ("Fetch", "FetchDone", {"times_us": list(range(9)), "fields": 63}, "bad_value"),
                ("Subscribe", "FetchDone", {"fields": 1 << 6, "credit": 2}, "not_offered"),
                ("Subscribe", "FetchDone", {"fields": 63, "credit": 9}, "bad_value")):
            with self.assertRaises(client.Refused) as refusal:
                self.session.ask(kind, reply, **values)
            self.assertEqual(refusal.exception.code, client.SCHEMA.enums["ErrorCode"][code], kind)

    def close_code(self, act):
        """What the session ends with: the close frame's code, after GoAway where one comes."""
        session = client.Session(self.host, self.port)
        act(session)
        gone = None
        try:
            while True:
                message = client.SCHEMA.read_message(session.socket.receive())
                gone = message["code"] if message["kind"] == "GoAway" else gone
        except websocket.Closed as closed:
            session.socket.close()
            return gone, closed.code

    def test_a_stream_goes_on_whatever_its_credit_and_however_many_keyframes_an_ack_names(self):
        class Counting(client.Session):
            def send(self, kind, **values):
                if kind == "Ack":
                    named.append(1 + len(values["also"] or []))
                super().send(kind, **values)

        for takes in (0, 9):  # 0: as to a server that knows Acks of one keyframe alone
            named = []
            session = Counting(self.host, self.port)
            self.assertEqual(session.welcome["keyframes_per_ack_max"], 9)
            session.welcome["keyframes_per_ack_max"] = takes
            for credit, most in ((8, 4), (1, 1), (4, 2)):
                session.subscribe(credit=credit)
                del named[:]
                while sum(named) < 3 * credit:  # more than the window holds: it is given back
                    session.receive()
                self.assertEqual(set(named), {most if takes else 1}, f"credit {credit}")
            session.socket.close()

    def test_sessions_end_with_the_codes_of_the_page(self):
        text = self.close_code(lambda s: s.socket.send(b"hello", opcode=websocket.TEXT))
        self.assertEqual(text, (1, 4001))
        second = self.close_code(lambda s: s.send("Hello", versions=[1], client="", token=""))
        self.assertEqual(second, (1, 4001))
        self.assertEqual(self.close_code(lambda s: s.send("Ack", keyframe=1, also=[2] * 9)), (5, 4005))
        self.assertEqual(self.close_code(lambda s: s.socket.send(b"unmasked", masked=False)), (None, 1002))
        self.assertEqual(self.close_code(lambda s: s.socket.send(b"", announced=200_000)), (None, 1009))

    def test_pages_answer_as_the_page_says(self):
        def status(method, path):
            number, allow, body = self.http(method, path)
            return number, allow, len(body)
        self.assertEqual(status("GET", "/healthz"), (200, None, 3))
        self.assertEqual(status("HEAD", "/healthz"), (200, None, 0))
        self.assertEqual(status("HEAD", "/v1/map?columns=2&rows=2&width_m=4&height_m=4"), (200, None, 0))
        self.assertEqual(status("POST", "/v1/state")[:2], (405, "GET, HEAD"))
        self.assertEqual(status("POST", "/v1/map")[:2], (405, "GET, HEAD"))
        self.assertEqual(status("GET", "/nowhere")[0], 404)
        self.assertEqual(status("GET", "/v1/stream")[0], 426)
        self.assertEqual(status("GET", "/v1/map?t_s=1e13")[0], 400)
        self.assertEqual(status("GET", "/v1/map?columns=5000")[0], 400)
        with self.assertRaises(websocket.HandshakeFailed) as failed:
            websocket.WebSocket(self.host, self.port, "/v1/stream", None)
        self.assertEqual(failed.exception.status, 400)
        with socket.create_connection((self.host, self.port), timeout=60) as raw:
            raw.sendall(b"GET / HTTP/1.1\r\nX: " + b"x" * 9000 + b"\r\n\r\n")
            self.assertIn(b" 431 ", raw.recv(4096))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The model of fleet_model.py on costs that are made up, and that the page has what the measured ones give."""
import random
import re
import subprocess
import sys
import pathlib
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import fleet_model  # noqa: E402

TRUE = {"there": 1e-3, "session": 20e-6, "predicted": 9e-3, "compact": 1e-2, "whole": 3e-2, "keyframe": 10e-6, "megabyte": 2e-4, "asked": 2e-2,
        "ask": 4e-5}
BYTES = {"": 0, "predicted": 1300, "compact": 50_000, "whole": 200_000}


def run_of(place, what, true=TRUE, noise=0.0):
    kind, readers, idle, askers, asks = what
    run = {"place": place, "kind": kind, "readers": readers, "sessions": readers + idle + askers, "keyframes_a_s": 6.3 * readers,
           "mb_a_s": 1e-6 * BYTES[kind] * 6.3 * readers, "asks_a_s": asks * askers}
    cores = sum(true[name] * float(count(run)) for name, _, _, count in fleet_model.TERMS) * (1 + noise)
    return {**run, "cores": cores, "busiest_cores": 0.6 * cores}


def runs_of(true=TRUE, noise=0.0):
    draw = random.Random(72)
    return [run_of("alone", what, true, noise * draw.uniform(-1, 1)) for what in fleet_model.ALONE]


class AModel(unittest.TestCase):
    def test_finds_the_costs_that_runs_were_made_of(self):
        found = fleet_model.Model(runs_of(), "cores").terms
        for name, cost in TRUE.items():
            self.assertAlmostEqual(found[name] / cost, 1, 6, name)

    def test_foretells_a_mixture_that_it_has_not_seen_as_well_as_runs_were_measured(self):
        model = fleet_model.Model(runs_of(noise=0.05), "cores")
        mixed = [run_of("mixed", what) for what in fleet_model.MIXED]
        # Runs that are 5 % off are averaged by the fit, some of them by few others: no more than twice that is left.
        self.assertLess(max(map(abs, model.errors(mixed))), 0.1)

    def test_has_no_cost_below_nothing(self):
        true = {**TRUE, "there": 0.0, "session": 0.0}
        self.assertGreaterEqual(min(fleet_model.Model(runs_of(true, 0.2), "cores").terms.values()), 0)

    def test_says_by_how_much_it_is_above(self):
        model = fleet_model.Model(runs_of(), "cores")
        half = {**run_of("mixed", fleet_model.MIXED[0])}
        half["cores"] /= 2
        self.assertAlmostEqual(model.errors([half])[0], 1, 6)


class APlan(unittest.TestCase):
    def test_fills_no_thread_beyond_its_share_and_no_server_beyond_what_was_tried(self):
        for kind in ("predicted", "compact"):
            for clients in (1, 1e4, 1e6):
                plan = fleet_model.Plan(clients, kind, runs_of())
                self.assertLessEqual(plan.busiest_cores, fleet_model.NETWORK_CORES)
                self.assertLessEqual(plan.sessions, fleet_model.SESSIONS_MOST)
                self.assertGreaterEqual(plan.servers * plan.sessions, clients)

    def test_says_how_far_it_is_beyond_what_runs_have_held(self):
        runs = runs_of()  # of 300 compact readers and 2000 questions a second at most
        small, large = fleet_model.Plan(150, "compact", runs), fleet_model.Plan(1e5, "compact", runs)
        self.assertAlmostEqual(small.beyond["readers"], 150 / small.servers / 300)
        self.assertAlmostEqual(large.beyond["readers"], 1e5 / large.servers / 300)
        self.assertAlmostEqual(large.beyond["asks_a_s"], fleet_model.ASKS * 1e5 / large.servers / 2000)
        self.assertGreater(large.beyond["readers"], 10)
        self.assertLessEqual(large.beyond["sessions"], 1)

    def test_is_of_servers_that_take_so_many_sessions_as_deploy_fleet_can_be_told(self):
        self.assertEqual(fleet_model.Room().told, fleet_model.SESSIONS_MOST)

    def test_loses_one_server_and_still_has_room(self):
        for clients in (1, 5000, 1e5):
            plan = fleet_model.Plan(clients, "compact", runs_of())
            self.assertGreaterEqual((plan.servers - 1) * plan.sessions, clients)

    def test_needs_more_where_a_keyframe_costs_more(self):
        dear = runs_of({**TRUE, "keyframe": 60e-6})
        self.assertGreater(fleet_model.Plan(1e5, "predicted", dear).servers, fleet_model.Plan(1e5, "predicted", runs_of()).servers)


class AnEngine(unittest.TestCase):
    def test_goes_by_servers_and_by_words_from_each_to_each(self):
        words = [{"servers": n, "cores": 1e-4 * n + 1e-6 * n * n} for n in (4, 50, 200)]
        rows = [{"servers": n, "messages_a_s": 8.0 * n + n + n * n, "kilobytes_a_s": 3.0 * n + 1e-3 * (n + n * n) * fleet_model.word_bytes(n),
                 "cores": 0.0021 * n + 1e-6 * n * n} for n in (1, 2, 3, 4)]
        engine = fleet_model.Engine(rows, words)
        self.assertAlmostEqual(engine("messages_a_s", 100), 10_900, 3)
        self.assertAlmostEqual(engine("kilobytes_a_s", 100), 300 + 10.1 * fleet_model.word_bytes(100), 3)
        self.assertAlmostEqual(engine("cores", 100), 0.22, 6)

    def test_knows_how_long_the_words_of_servers_are(self):
        code = (fleet_model.SOURCE / "server/journal/peer_clocks.cpp").read_text()
        head, line = re.search(r'format\("(.*?)\\n", clock_magic', code)[1], re.search(r'format\("(.*?)\\n", name, peer', code)[1]
        magic = re.search(r'magic = "(.*?)"', code)[1]
        name, time, held = "0123456789abcdef", "1" * 12, "1" * 6
        for servers in (1, 4, 9, 10, 255):
            answered = min(servers - 1, 8)
            word = head.format(magic, name, time, time) + "\n" + answered * (line.format(name, time, held) + "\n")
            self.assertEqual(fleet_model.word_bytes(servers), len(word), servers)

    def test_foretells_what_was_measured(self):
        measured = fleet_model.read(fleet_model.NATS)
        engine = fleet_model.Engine(measured, fleet_model.read(fleet_model.WORDS))
        # Times of servers that have just started are four digits shorter each than the model has them: 8 to 12 bytes in 100.
        for row in measured:
            for column in ("messages_a_s", "kilobytes_a_s"):
                self.assertAlmostEqual(engine(column, row["servers"]) / row[column], 1, delta=0.03, msg=f"{column} of {row}")
        for row in fleet_model.read(fleet_model.WORDS):
            for column in ("messages_a_s", "kilobytes_a_s"):
                self.assertAlmostEqual(engine.words(column, row["servers"]) / row[column], 1, delta=0.03, msg=f"{column} of {row}")


class ThePage(unittest.TestCase):
    def test_has_what_the_measured_costs_give(self):
        said = subprocess.run([sys.executable, "-B", fleet_model.__file__], capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 0, said.stdout + said.stderr)


if __name__ == "__main__":
    unittest.main()

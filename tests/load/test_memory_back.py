#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a flood has taken of a server's memory goes back to the system.

    test_memory_back.py BUILD_DIR

A real server, a client, and 64 sessions that fetch and ask all they may and read nothing, as load_price.py has them. Of clients
there are who takes whole maps and asks single points, who samples one point, and who asks for it: the thinner one is, the less its
server had before. Resident size is a property, not a time: a busy machine makes it no larger.
"""
import argparse
import multiprocessing
import pathlib
import subprocess
import sys
import time
import unittest

import load_price

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
UNREAD = argparse.Namespace(attack="unread", attackers=4)


class MemoryBack(unittest.TestCase):
    def serve(self, device="native"):
        self.server = load_price.Served(BUILD / "bin/seaway-server", load_price.ROOT / "scenes/north_sea_gale.toml", "--device", device)
        self.addCleanup(self.server.stop)

    def reads_maps(self):
        stop, report = multiprocessing.Event(), multiprocessing.Queue()
        reader = multiprocessing.Process(target=load_price.healthy, args=(
            self.server.port, stop, load_price.SURFACE_FIELDS, "now", report))
        reader.start()
        for last_first in (reader.join, report.get, stop.set):
            self.addCleanup(last_first)
        return lambda: reader.exitcode is None

    def queries(self, *how):
        query = subprocess.Popen([BUILD / "bin/seaway-query", f"ws://127.0.0.1:{self.server.port}", "--at", "1,2", "--watch", "20", *how],
                                 stdout=subprocess.DEVNULL)
        for last_first in (query.wait, query.kill):
            self.addCleanup(last_first)
        return lambda: query.poll() is None

    def flood(self, enough_mb):
        stop, report = multiprocessing.Event(), multiprocessing.Queue()
        attackers = load_price.start_attack(UNREAD, self.server.port, stop, report)
        until_s, most_mb = time.monotonic() + 60, 0
        while most_mb < enough_mb and time.monotonic() < until_s:
            time.sleep(0.2)
            most_mb = max(most_mb, load_price.memory_mb(self.server.process.pid))
        time.sleep(3)
        stop.set()
        for one in attackers:
            report.get(timeout=120)
            one.join()
        return most_mb

    def is_back(self, still_there):
        """Where what was freed stayed in the heaps of the threads that took it, it would be twice as much for good."""
        time.sleep(6)  # what holds keyframes fills
        before_mb = load_price.settled_mb(self.server.process.pid, 3)
        self.assertGreater(self.flood(1.6 * before_mb), 1.5 * before_mb, "it is a flood")
        until_s = time.monotonic() + 60
        while (after_mb := load_price.settled_mb(self.server.process.pid, 1)) > 1.2 * before_mb:
            self.assertLess(time.monotonic(), until_s, f"{after_mb:.1f} MB, {before_mb:.1f} before")
        self.assertTrue(still_there(), "whoever was there before still is")

    def test_a_minute_after_a_flood_a_server_has_at_most_a_fifth_more_than_before_beside_who_reads_maps(self):
        self.serve()
        self.is_back(self.reads_maps())

    def test_and_beside_who_samples_one_point(self):
        self.serve()
        self.is_back(self.queries("--local"))

    def test_and_beside_who_asks_for_one_point(self):
        self.serve()
        self.is_back(self.queries("--format", "csv"))

    def test_and_on_lavapipe_whose_maps_are_held_in_a_pool(self):
        """What the flood had touched of the pool would stay: as much as there was before."""
        self.serve("lavapipe")
        self.is_back(self.queries("--format", "csv"))


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # sockets of attackers end with them

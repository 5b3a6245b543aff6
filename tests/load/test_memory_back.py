#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a flood has taken of a server's memory goes back to the system.

    test_memory_back.py BUILD_DIR

A real server, a subscriber who asks single points, and 64 sessions that fetch and ask all they may and read nothing,
as load_price.py has them. Resident size is a property, not a time: a busy machine makes it no larger.
"""
import argparse
import multiprocessing
import pathlib
import sys
import time
import unittest

import load_price

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
UNREAD = argparse.Namespace(attack="unread", attackers=4)


class MemoryBack(unittest.TestCase):
    def setUp(self):
        self.server = load_price.Served(BUILD / "bin/seaway-server", load_price.ROOT / "scenes/north_sea_gale.toml", "--device", "native")
        self.addCleanup(self.server.stop)
        stop, report = multiprocessing.Event(), multiprocessing.Queue()
        self.reader = multiprocessing.Process(target=load_price.healthy, args=(
            self.server.port, stop, load_price.SURFACE_FIELDS, "now", report))
        self.reader.start()
        for last_first in (self.reader.join, report.get, stop.set):
            self.addCleanup(last_first)

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

    def test_a_minute_after_a_flood_a_server_has_at_most_a_fifth_more_than_before(self):
        """Where what was freed stayed in the heaps of the threads that took it, it would be twice as much for good."""
        time.sleep(6)  # what holds keyframes fills
        before_mb = load_price.settled_mb(self.server.process.pid, 3)
        self.assertGreater(self.flood(1.6 * before_mb), 1.5 * before_mb, "it is a flood")
        until_s = time.monotonic() + 60
        while (after_mb := load_price.settled_mb(self.server.process.pid, 1)) > 1.2 * before_mb:
            self.assertLess(time.monotonic(), until_s, f"{after_mb:.0f} MB, {before_mb:.0f} before")
        self.assertEqual(self.reader.exitcode, None, "who reads is still there")


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # sockets of attackers end with them

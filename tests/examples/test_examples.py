#!/usr/bin/env python3
"""The examples run as they are written, and what they show is so.

    test_examples.py BUILD_DIR

All of them against one server on the gale. What they draw was looked at; here it is measured.
"""
import ctypes
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
SCENE = ROOT / "scenes/north_sea_gale.toml"
sys.path += [str(ROOT / "tests/support"), str(ROOT / "examples/python")]
os.environ["SEAWAY_LIBRARY"] = str(BUILD / "lib/libseaway.so.0")

from served import Served  # noqa: E402


# A library whose still sea becomes another one after a third of a second, 95 s back, and has water at every time throughout.
BECOMES_ANOTHER = """
#include <seaway/seaway.h>
static int the_client;
static int64_t calls;
const char* seaway_last_error(void) { return ""; }
seaway_code seaway_connect(const char* url, const seaway_connect_options* options, seaway_client** client) {
    (void)url, (void)options;
    *client = (seaway_client*)(void*)&the_client;
    return SEAWAY_OK;
}
void seaway_disconnect(seaway_client* client) { (void)client; }
seaway_code seaway_subscribe(seaway_client* client, const seaway_subscription* subscription) {
    (void)client, (void)subscription;
    return SEAWAY_OK;
}
int64_t seaway_now_us(seaway_client* client) {
    (void)client;
    calls += 1;
    return (calls < 20 ? 100000000 : 5000000) + calls * 16667;
}
seaway_code seaway_sample(const seaway_client* client, const seaway_point* points, size_t count, seaway_answer* answers) {
    (void)client, (void)points;
    for (size_t i = 0; i < count; ++i) {
        const seaway_answer still = {.normal = {0, 0, 1}};
        answers[i] = still;
    }
    return SEAWAY_OK;
}
"""


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.work = pathlib.Path(cls.folder.name)
        cls.server = Served(BUILD / "bin/seaway-server", SCENE, "--device", "native")
        cls.url = cls.server.url

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls.folder.cleanup()

    def run_example(self, *command, code=0):
        environment = {**os.environ, "PATH": f"{BUILD / 'bin'}:{os.environ['PATH']}"}
        done = subprocess.run(command, cwd=self.work, env=environment, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def compiles(self, program):
        done = subprocess.run(["cc", "-std=c11", "-fsyntax-only", "-x", "c", f"-I{BUILD}/include", "-"], input=program,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def table(self, text):
        return numpy.genfromtxt(text.splitlines(), delimiter=",", names=True)

    def once_of_three(self, off):
        """They run by the clock: a machine that stands still for half a second leaves them where the water was."""
        why = next((why for why in (off() for _ in range(3)) if not why), None)
        self.assertIsNotNone(why, "three times")

    def test_a_buoy_rides_the_waves(self):
        def off():
            rows = self.table(self.run_example(BUILD / "bin/example_buoy", self.url, "12"))
            self.assertGreaterEqual(len(rows), 11)
            # It starts at 0 wherever the water is; after a few seconds it is within its own height of it.
            return numpy.abs(rows["buoy_m"] - rows["water_m"])[5:].max() >= 1.2 or not (rows["error_m"] < 0.1).all()
        self.once_of_three(off)

    def test_a_buoy_goes_on_where_the_sea_has_become_another_of_an_earlier_time(self):
        (self.work / "another.c").write_text(BECOMES_ANOTHER)
        self.run_example("cc", "-std=c11", "-O1", f"-I{BUILD}/include", ROOT / "examples/buoy.c", "another.c", "-lm", "-o",
                         "another_sea")
        rows = self.table(self.run_example(self.work / "another_sea", "ws://nowhere:1", "1.2"))
        self.assertEqual(len(rows), 2)
        self.assertGreater(rows["time_s"][0], 100)
        self.assertLess(rows["time_s"][1], 10)

    def test_a_freighter_rides_the_gale_for_ten_minutes_without_tunnelling_or_jitter(self):
        self.run_example(BUILD / "bin/example_ship", self.url, "ship.csv", "ship.svg")
        rows = self.table((self.work / "ship.csv").read_text())
        self.assertEqual(len(rows), 6000)
        self.assertTrue(all(numpy.isfinite(rows[name]).all() for name in rows.dtype.names))
        # Not through the water: 5.5 m of freeboard and 6.5 m of draught are amidships never used up.
        self.assertLess(numpy.abs(rows["heave_m"] - rows["water_m"]).max(), 5.5)
        self.assertLess(numpy.abs(rows["roll_deg"]).max(), 30)
        self.assertLess(numpy.abs(rows["pitch_deg"]).max(), 20)
        # It does ride: a gale of Hs 6 m lifts 120 m of ship by more than a tenth of that.
        self.assertGreater(rows["heave_m"].std(), 0.6)
        # No jitter: a ship of 6 s and more has nearly nothing above 0.5 Hz, and no step is felt as a knock.
        for name in ("heave_m", "roll_deg", "pitch_deg"):
            power = numpy.abs(numpy.fft.rfft(rows[name] - rows[name].mean())) ** 2
            fast = numpy.fft.rfftfreq(len(rows), 0.1) > 0.5
            self.assertLess(power[fast].sum(), 2e-3 * power.sum(), name)
        self.assertLess(numpy.abs(numpy.diff(rows["heave_m"], 2)).max() / 0.1 ** 2, 9.81 / 2)
        plot = (self.work / "ship.svg").read_text()
        self.assertEqual(plot.count("<polyline"), 3)

    def test_a_freighter_whose_log_does_not_fit_on_the_disk_says_so(self):
        for files in (["/dev/full", "short.svg"], ["short.csv", "/dev/full"]):
            said = self.run_example(BUILD / "bin/example_ship", self.url, *files, "2", code=1)
            self.assertEqual(said, "ship: cannot write /dev/full\n")

    def test_a_fleet_asks_in_one_batch_and_stays_on_the_water(self):
        def off():
            said = self.run_example(BUILD / "bin/example_fleet", self.url, "60")
            figures = re.fullmatch(r"1000 floats, 4000 points in one batch: a step takes (\d+) us for the water and (\d+) us "
                                   r"for the floats \(medians of 60\); none is further than (\d+\.\d+) m from the water\n", said)
            self.assertTrue(figures, said)
            return float(figures.group(3)) >= 1.5
        self.once_of_three(off)

    def test_buoys_in_python_measure_the_spectrum_that_was_asked_for(self):
        said = self.run_example(sys.executable, "-B", ROOT / "examples/python/buoy_spectrum.py", self.url,
                                SCENE, "buoy.csv", "spectrum.png")
        measured, asked, peak, peak_asked = map(float, re.fullmatch(
            r"Hs ([\d.]+) m measured, ([\d.]+) m asked for; peak ([\d.]+) Hz and ([\d.]+) Hz\n", said).groups())
        # 25 records of half an hour on one realisation: 5 %, twice; the peak within two lines of 1/256 Hz.
        self.assertLess(abs(measured / asked - 1), 0.1)
        self.assertLessEqual(abs(peak - peak_asked), 2 / 256 + 1e-3)
        self.assertEqual((self.work / "buoy.csv").read_text().count("\n"), 1 + 7200)
        self.assertTrue((self.work / "spectrum.png").read_bytes().startswith(b"\x89PNG"))

    def test_without_a_server_they_say_so(self):
        nobody = "ws://127.0.0.1:1"
        for command in ([BUILD / "bin/example_buoy", nobody], [BUILD / "bin/example_ship", nobody],
                        [BUILD / "bin/example_fleet", nobody],
                        [sys.executable, "-B", ROOT / "examples/python/buoy_spectrum.py", nobody, SCENE]):
            said = self.run_example(*command, code=1)
            self.assertIn("127.0.0.1:1", said)
            self.assertEqual(said.count("\n"), 1, said)

    def test_structs_in_python_are_those_of_the_header(self):
        import seaway
        sizes = {"seaway_point": seaway.POINT.itemsize, "seaway_answer": seaway.ANSWER.itemsize,
                 "seaway_subscription": ctypes.sizeof(seaway.Subscription), "seaway_sea": ctypes.sizeof(seaway.SeaAt),
                 "seaway_sampling": ctypes.sizeof(seaway.Sampling), "seaway_terms": seaway.TERMS.itemsize}
        checks = "".join(f'_Static_assert(sizeof({name}) == {size}, "{name}");\n' for name, size in sizes.items())
        checks += f'_Static_assert(SEAWAY_ABI_VERSION == {seaway.ABI_VERSION}, "version");\n'
        self.compiles("#include <seaway/seaway_engine.h>\n" + checks)
        with seaway.Sea(self.url) as sea:
            asked = seaway.points([[0.0, 10.0, 20.0]], 5.0, sea.now_us())
            served = sea.query(asked, exact=True)
            sea.subscribe(seaway.SPECTRUM)
            sampled = sea.sample(asked)
            self.assertEqual(sampled.shape, (1, 3))
            off = numpy.abs(served["height_m"] - sampled["height_m"])
            self.assertTrue((off <= served["error_m"] + sampled["error_m"]).all(), off)
            self.assertGreater(sea.at(sea.now_us()).hs_m, 4)
            terms = sea.terms(asked, seaway.TIMES_OF_NOW)
            self.assertTrue((terms["answer"]["height_m"] == sampled["height_m"]).all())
            parts = {name: terms[name] for name in seaway.TERMS.names if name != "answer"}
            square = numpy.sqrt(sum(parts.pop(name)**2 for name in ("codec_m", "time_m", "space_m")))
            numpy.testing.assert_allclose(square + sum(parts.values()), terms["answer"]["error_m"], rtol=1e-12)
            self.assertTrue((terms["clock_m"] > 0).all())

    def test_the_page_for_engines_calls_what_there_is(self):
        page = (ROOT / "examples/engine.md").read_text()
        headers = "".join((ROOT / "client" / name).read_text() for name in ("seaway.h", "seaway_engine.h", "buoyancy.h", "buoyancy_panel.h"))
        names = set(re.findall(r"\b(?:seaway_\w+|SEAWAY_\w+)", page))
        self.assertGreater(len(names), 12)
        for name in names:
            self.assertRegex(headers, rf"\b{name}\b")
        for i, program in enumerate(re.findall(r"```cpp\n(.*?)```", page, re.S)):
            done = subprocess.run(["c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++",
                                   f"-I{BUILD}/include", "-"], input=program, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"program {i}: {done.stderr}")
        self.assertTrue(shutil.which("c++"))

    def test_structs_in_the_page_for_engines_are_those_of_the_header(self):
        """Field by field: C# lays them out in their order, and two that change places have the same size."""
        page = (ROOT / "examples/engine.md").read_text()
        in_c = {"Point": ("seaway_point", {"x": "x_m", "y": "y_m", "timeUs": "time_us"}),
                "Answer": ("seaway_answer", {
                    "height": "height_m", "nx": "normal[0]", "ny": "normal[1]", "nz": "normal[2]", "vx": "velocity_mps[0]",
                    "vy": "velocity_mps[1]", "vz": "velocity_mps[2]", "error": "error_m", "flags": "flags", "reserved": "reserved"})}
        sizes = {"double": 8, "long": 8, "uint": 4}
        structs = re.findall(r"\[StructLayout\(LayoutKind\.Sequential\)\] struct (\w+) \{(.*?)\}", page, re.S)
        self.assertEqual({name for name, _ in structs}, set(in_c))
        checks = "#include <stddef.h>\n#include <seaway/seaway.h>\n"
        for name, fields in structs:
            struct, members = in_c[name]
            at = 0
            for kind, names in re.findall(r"public (\w+) ([^;]*);", fields):
                for field in names.split(", "):
                    member = members.pop(field)
                    checks += (f'_Static_assert(offsetof({struct}, {member}) == {at}, "{name}.{field}");\n'
                               f'_Static_assert(sizeof((({struct}*)0)->{member}) == {sizes[kind]}, "{name}.{field}");\n')
                    at += sizes[kind]  # each is as wide as what it is aligned to
            self.assertEqual(members, {}, name)
            checks += f'_Static_assert(sizeof({struct}) == {at}, "{name}");\n'
        self.compiles(checks)


if __name__ == "__main__":
    unittest.main()

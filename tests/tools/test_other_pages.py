#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/effects_page.py, tools/hard_cases_page.py and what they share, on figures that are made up."""
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import effects_page  # noqa: E402
import hard_cases_page  # noqa: E402
import page_text  # noqa: E402

COUNTS = ["keyframes", "transforms", "maps_ms", "stream_ms", "kilobytes"]
LONG, SHORT = "500 m of 64", "50 m of 128"


def costs_of(folder, name, rows):
    """effects.csv of (what, effect, cascade, five numbers alone, five on top of the rest)."""
    path = pathlib.Path(folder) / name
    lines = ["# seaway-bench effects --scene x on native; a machine", "# of one second of sea",
             ",".join(["what", "effect", "cascade", *COUNTS, *(f"more_{c}" for c in COUNTS)])]
    lines += [",".join(map(str, [what, effect, cascade, *alone, *more])) for what, effect, cascade, alone, more in rows]
    path.write_text("\n".join(lines) + "\n")
    return effects_page.Costs(path)


def scene(folder, name, scale=1.0):
    """Two cascades and five effects, of which no two cost the same."""
    def five(start):
        return [round(scale * v, 6) for v in (0.5 + start, 2 + start, 3 * start + 1, 7 * start + 2, 40 * start + 10)]
    rows = [("everything", "", "", five(40), five(40)), ("asked", "height foam", "", five(10), five(10))]
    for c, cascade in enumerate((LONG, SHORT)):
        rows.append(("cascade", "", cascade, five(15 + 9 * c), five(15 + 9 * c)))
        rows += [("effect", effect, cascade, five(1 + e + 6 * c), five(0.1 + 0.3 * e + 2 * c))
                 for e, effect in enumerate(effects_page.EFFECTS)]
    return costs_of(folder, name, rows)


def cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()
            if not line.startswith("|---")]


class Effects(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def test_what_is_on_top_of_the_rest_stands_by_effect_and_cascade_with_its_sums(self):
        # On top of the rest, s = 0.1 + 0.3 e + 2 c: maps 3 s + 1, stream 7 s + 2, kilobytes 40 s + 10, transforms s + 2.
        rows = cells(effects_page.marginal_table(scene(self.folder.name, "x.csv")))
        self.assertEqual(rows[0][:3], ["", LONG, SHORT])
        self.assertEqual(rows[1], ["height", "1.3 + 2.7", "7.3 + 16.7", "28", "108", "6.2"])
        self.assertEqual(rows[5], ["foam", "4.9 + 11.1", "10.9 + 25.1", "52", "204", "8.6"])
        # The cascades: s = 15 and 24, less the sums over five effects (s = 0.7 and 2.7 on average).
        shared = [46 - 15.5, 107 - 34.5, 73 - 45.5, 170 - 104.5]
        self.assertEqual(rows[6][:3], ["shared by foam and gradient", f"{shared[0]:.3g} + {shared[1]:.3g}",
                                       f"{shared[2]:.3g} + {shared[3]:.3g}"])
        self.assertEqual(rows[6][3:], ["196", f"{610 + 970 - 190 - 590:.0f}", f"{17 + 26 - 13.5 - 23.5:.3g}"])
        self.assertEqual(rows[7], ["**all of a cascade**", "**46 + 107**", "**73 + 170**", "396", "1580", "43"])
        self.assertEqual(rows[8][:3], ["keyframes/s", "15.5", "24.5"])

    def test_scenes_compare_what_is_asked_with_everything(self):
        costs = {file: scene(self.folder.name, file, 1 + i) for i, (file, *_) in enumerate(effects_page.SCENES)}
        rows = cells(effects_page.scenes_table(costs))
        # s = 10: 12 transforms, 31 + 72 ms, 410 kB; s = 40: 42, 121 + 282, 1610; 403 / 103 = 3.91.
        self.assertEqual(rows[1], ["**a pond**", "height, foam", "12", "31", "72", "410", "1"])
        self.assertEqual(rows[2], ["", "*everything*", "42", "121", "282", "1610", "3.91"])
        self.assertEqual(rows[3][:4], ["**a gale**", "height, foam", "24", "62"])

    def minute(self):
        """Counters that grow by 2, 5 and 11 a second in turn, read twice a second; guests at their times."""
        guests = [(10, 60, "a buoy"), (20, 55, "hulls"), (30, 50, "a viewer"), (35, 48, "another"), (40, 46, "strains")]
        lines = ["# made up"] + [f"# guest: {a} to {b} s, {name}" for a, b, name in guests]
        lines.append("t_s,sessions,height@0,foam@0,foam@1")
        for i in range(141):
            t = i / 2
            # Nothing before 10 s; from 30 s on foam starts with a burst of 30 over one second.
            height = 2 * max(t - 10, 0)
            foam = 5 * max(t - 30, 0) + 30 * min(max(t - 30, 0), 1)
            lines.append(f"{t},{sum(a <= t < b for a, b, _ in guests)},{height},{foam},{11 * max(t - 35, 0)}")
        path = pathlib.Path(self.folder.name) / "demand.csv"
        path.write_text("\n".join(lines) + "\n")
        return effects_page.Minute(path)

    def test_rates_are_of_the_span_that_is_asked_for_and_of_the_columns_that_are_named(self):
        minute = self.minute()
        self.assertEqual(minute.guests[2], ("a viewer", 30, 50))
        self.assertEqual(minute.columns, ["height@0", "foam@0", "foam@1"])
        self.assertEqual((minute.sessions[0], minute.sessions[90]), (0, 5))
        self.assertAlmostEqual(minute.rate(12, 19), 2)
        self.assertAlmostEqual(minute.rate(32, 34), 7)
        self.assertAlmostEqual(minute.rate(32, 34, "foam"), 5)
        self.assertAlmostEqual(minute.rate(50, 60, "@1"), 11)
        self.assertAlmostEqual(minute.total(60), 2 * 20)

    def test_each_word_is_the_figure_of_its_name(self):
        costs = {"gale": scene(self.folder.name, "gale"), "film_shot": scene(self.folder.name, "film", 2),
                 "pond": scene(self.folder.name, "pond", 3)}
        words = effects_page.words(costs, self.minute())
        expected = {
            "POND_TIMES": "3.9", "GALE_SAVED": "74", "FILM_WORK": "806",
            # Of 121 ms of maps: height 1.3 + 7.3, foam 4.9 + 10.9; gradient (s = 1 and 3): 9 + 23 of 282 ms of stream.
            "HEIGHT_SHARE": "7.1", "FOAM_SHARE": "13", "STREAM_SHARE": "70", "GRADIENT_SHARE": "11",
            "SHORTEST_SHARE": "60", "SUM_OFF": "2", "BUOY_RATE": "2", "HULLS_RATE": "2", "SECOND_BEFORE": "7",
            "SECOND_AFTER": "18", "STRAINS_RATE": "18", "BEFORE": "0", "AFTER": "18", "FOAM_START": "25",
            "MACHINE": "native; a machine"}
        for word, text in expected.items():
            self.assertEqual(words[word], text, word)
        self.assertEqual(set(words), set(expected) | {"SCENES", "POND", "GALE", "FILM"})


class HardCases(unittest.TestCase):
    def figures(self, tests):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "figures.json"
            path.write_text(json.dumps({"testsuites": [{"name": "Suite", "testsuite": tests}]}))
            return hard_cases_page.figures(path)

    def test_figures_are_of_a_whole_and_green_run(self):
        good = {"name": "a1_fine", "status": "RUN", "figure_ours": "1"}
        self.assertEqual(self.figures([good]), {"Suite.a1_fine": good})
        for bad in ({"name": "a1_red", "status": "RUN", "failures": [{"failure": "x"}]},
                    {"name": "a1_left_out", "status": "NOTRUN"}):
            with self.assertRaises(SystemExit) as stopped:
                self.figures([good, bad])
            self.assertIn(bad["name"], str(stopped.exception))
            self.assertNotIn("a1_fine", str(stopped.exception))

    def test_a_cell_tells_whose_figure_is_which(self):
        test = {"input": "a | b", "unit": "m", "figure_naive": "12000000", "figure_ours": "3"}
        self.assertEqual(hard_cases_page.measured(test), r"a \| b: m: naive 12000000, ours **3**")
        del test["figure_naive"]
        self.assertEqual(hard_cases_page.measured(test), r"a \| b: m: ours **3**")
        self.assertEqual(hard_cases_page.measured({"input": "x"}), "")

    def test_figures_are_read_without_exponents_where_three_digits_will_do(self):
        for text, shown in (("2", "2"), ("-4.0", "-4"), ("1e3", "1000"), ("99999", "99999"), ("1e5", "1e5"), ("0.25", "0.25"),
                            ("1.5e-7", "1.5e-7"), ("nan", "no number"), ("inf", "infinite")):
            self.assertEqual(hard_cases_page.figure(text), shown, text)

    def test_a_name_carries_an_id_that_is_a_word_of_its_own(self):
        self.assertTrue(hard_cases_page.carries("Spectrum.A1_the_peak", "A1"))
        self.assertTrue(hard_cases_page.carries("Spectrum.the_peak_of_a1", "A1"))
        self.assertFalse(hard_cases_page.carries("Spectrum.a12_the_peak", "A1"))

    def test_a_row_holds_first_the_tests_of_the_suite_then_those_that_are_named(self):
        files = {"tests/hard_cases/a.cpp": ["A.a7_one", "A.a17_other"], "tests/sea/b.cpp": ["B.a7_elsewhere", "B.named"]}
        case = {"case": "c", "naive": "n", "here": "h", "tests": ["B.named", "A.a7_one"], "reason": "why"}
        tests = hard_cases_page.tests_of("A7", case, files)
        self.assertEqual(tests, ["A.a7_one", "B.named"])
        recorded = {"B.named": {"input": "i", "unit": "s", "figure_ours": "2", "figure_naive": "8"}}
        self.assertEqual(hard_cases_page.row("A7", case, tests, recorded),
                         "| A7 | c | n | h | i: s: naive 8, ours **2** | `A.a7_one`, `B.named` |")
        self.assertEqual(hard_cases_page.row("A7", case, [], {}), "| A7 | c | n | h |  | why |")


class Text(unittest.TestCase):
    def test_metres_are_told_in_the_unit_that_leaves_few_digits(self):
        for value, text in ((None, "-"), (12.3, "12 m"), (123.4, "123 m"), (1, "1 m"), (0.9995, "1 m"), (0.9994, "100 cm"), (99.7, "100 m"),
                            (0.5, "50 cm"), (0.01, "1 cm"), (0.0099, "9.9 mm"), (1e-3, "1 mm"), (1e-5, "0.01 mm"),
                            (9e-6, "9 um"), (3e-7, "0.3 um")):
            self.assertEqual(page_text.metres(value), text, value)

    def test_numbers_keep_the_digits_asked_for_below_a_hundred(self):
        for (value, digits), text in (((None, 2), "-"), ((99.4, 2), "99"), ((100.4, 2), "100"), ((99.7, 2), "100"), ((99.7, 3), "99.7"), ((-1234.5, 2), "-1234"),
                                      ((0.01234, 2), "0.012"), ((0.01234, 3), "0.0123"), ((3.14159, 4), "3.142")):
            self.assertEqual(page_text.number(value, digits), text)

    def test_every_word_is_filled_once_and_none_is_left(self):
        self.assertEqual(page_text.filled("{{A}} and {{B}}, {{A}}", {"A": "1", "B": "2"}), "1 and 2, 1")
        for template, words, name in (("{{A}}", {"A": "1", "B": "2"}, "B"), ("{{A}} {{C}}", {"A": "1"}, "C")):
            with self.assertRaisesRegex(KeyError, name):
                page_text.filled(template, words)

    def test_a_table_has_its_head_its_rule_and_its_rows(self):
        self.assertEqual(page_text.table(["a", "b"], [["1", "2"], ["3", "4"]]), "| a | b |\n|---|---|\n| 1 | 2 |\n| 3 | 4 |")


if __name__ == "__main__":
    unittest.main()

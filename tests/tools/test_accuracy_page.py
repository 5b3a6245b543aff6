#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/accuracy_page.py and its plots on measurements that are made up: no two figures are equal, and each
cell is worked out by hand."""
import csv
import pathlib
import re
import sys
import tempfile
import types
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
# Plots are looked at before they are drawn: nothing here needs matplotlib.
sys.modules["plot_style"] = types.SimpleNamespace(COLOURS=["c0", "c1", "c2"], plt=unittest.mock.MagicMock())
import accuracy_page  # noqa: E402
import accuracy_pictures  # noqa: E402

COLUMNS = ["state", "knob", "value", "metric", "figure", "ci_low", "ci_high", "device", "driver", "machine", "commit"]
GALE = "gale_deep"
FOLDERS = tempfile.TemporaryDirectory()


def run_of(trials, device="native (two threads)", name="accuracy.csv", done=True):
    """{(state, knob, value): {metric: figure or (figure, low, high)}} as the Run of a file."""
    path = pathlib.Path(tempfile.mkdtemp(dir=FOLDERS.name)) / name
    with path.open("w", newline="") as file:
        file.write("# seaway-bench accuracy, seed 7\n")
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for key, metrics in trials.items():
            for metric, figure in [*metrics.items(), *([("done", 1)] if done else [])]:
                span = figure if isinstance(figure, tuple) else (figure, figure, figure)
                writer.writerow([*key, metric, *span, device, f"driver of {key[2]}", "a machine", "abc1234"])
    return accuracy_page.Run(path)


def cells(table):
    """The rows of a table of Markdown, heads first."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()
            if not line.startswith("|---")]


BALANCED = {"hs_m": 4.1, "rms_m": 0.011, "p99_m": 0.032, "p99_worst_m": 0.035, "max_m": 0.071, "p99_pct_hs": 0.78,
            "crest_m": -0.0012, "slope_rms": 0.013, "missing_rms_m": 0.021, "keyframe_cpu_ms_per_s": 5.2,
            "encode_ms_per_s": 31, "query_ns": 1700, "work_ms_per_s": 53, "bytes_per_s": 2.5e6, "memory_mb": 9.1,
            "flagged_pct": 0.15, "folded_pct": 0.27, "normal_p99_deg": 1.4, "velocity_rms_mps": 0.045,
            "flicker_m": 0.0023, "bound_over_p99": 6.3}


class Tables(unittest.TestCase):
    def test_ways_are_told_in_units_that_are_read_and_nothing_is_made_up(self):
        storm = dict(BALANCED, p99_m=0.05, p99_worst_m=0.062)
        summed = {"rms_m": 2e-7, "p99_m": 4e-7, "crest_m": 3e-6, "slope_rms": 0.5, "missing_rms_m": 0.02,
                  "query_ns": 250e3, "work_ms_per_s": 2501, "memory_mb": 0.3, "flagged_pct": 0}
        rows = cells(accuracy_page.ways_table(run_of({
            (GALE, "named", "balanced"): BALANCED, ("storm_deep", "named", "balanced"): storm,
            ("calm_deep", "named", "balanced"): dict(BALANCED, p99_m=0.001, p99_worst_m=0.002),
            (GALE, "named", "all modes summed"): summed})))
        self.assertEqual(rows[0][3], "p99, worst of 3 seas")
        self.assertEqual(rows[1], ["**balanced**", "1.1 cm", "3.2 cm", "6.2 cm", "-1.2 mm", "0.013", "2.1 cm", "5.2", "31",
                                   "1.7", "53", "20", "9.1", "0.15"])
        self.assertEqual(rows[2], ["all modes summed", "0.2 um", "0.4 um", "0.4 um", "3 um", "0.5", "2 cm", "-", "-",
                                   "250", "2501", "-", "0.3", "0"])
        self.assertEqual(len(rows), 3, "what was not measured has no row")

    def test_the_worst_counts_the_seeds_where_there_are_any(self):
        seeds = {f"p99_m@seed={n}": 0.01 * n for n in (1, 2, 3)}
        run = run_of({(GALE, "named", "balanced"): {**BALANCED, **seeds}})
        self.assertEqual(accuracy_page.seas_measured(run), "1 seas, 3 seeds each")
        self.assertEqual(run.worst("balanced", "p99_m"), 0.035)

    def test_states_have_each_figure_in_its_column(self):
        run = run_of({("storm_shallow", "named", "balanced"): BALANCED,
                      ("calm_deep", "named", "balanced"): dict(BALANCED, hs_m=0.45, folded_pct=0.03)})
        rows = cells(accuracy_page.states_table(run))
        self.assertEqual([row[0] for row in rows], ["sea", "calm, deep", "storm, shallow"])
        self.assertEqual(rows[2], ["storm, shallow", "4.1 m", "1.1 cm", "3.2 cm", "7.1 cm", "0.78", "1.4", "0.045", "2.3 mm",
                                   "2.1 cm", "6.3", "0.27"])
        self.assertEqual((rows[1][1], rows[1][11]), ("0.45 m", "0.03"))

    def test_a_law_holds_where_every_point_is_within_a_factor_of_two_on_either_side(self):
        def said(ratios, knob="latency", law=0.01, prefix="late"):
            run = run_of({(GALE, knob, f"{prefix}@{i}"): {"rms_m": ratio * law * (i + 1), "predicted_rms_m": law * (i + 1)}
                          for i, ratio in enumerate(ratios)})
            return cells(accuracy_page.law_table(run))[1:]
        self.assertEqual(said([1.2, 0.6, 1.9]), [["K14", "answers of a while ago", "3", "1 cm to 3 cm", "0.60 to 1.90",
                                                   "yes"]])
        self.assertEqual(said([1.2, 0.4])[0][4:], ["0.40 to 1.20", "see below"])
        self.assertEqual(said([0.7, 2.1])[0][4:], ["0.70 to 2.10", "see below"])
        # Below a micrometre float maps decide, not the grid; of the inverse only one curve has a law.
        self.assertEqual(said([5], "grid", 1e-7, "spline"), [])
        self.assertEqual(said([1.5], "grid", 1e-5, "spline")[0][0], "K2")
        self.assertEqual(said([1], "inverse", 0.01, "newton"), [])
        self.assertEqual(said([1], "inverse", 0.01, "fixed point")[0][0], "K10")

    def test_what_a_format_adds_is_beyond_what_full_floats_have(self):
        run = run_of({("gale_shallow", "format", "f32"): {"rms_m": 0.03},
                      ("gale_shallow", "format", "f16"): {"rms_m": 0.05, "predicted_format_m": 0.0401},
                      ("gale_shallow", "format", "snorm16"): {"rms_m": 0.034, "predicted_format_m": 0.0152}})
        self.assertEqual(cells(accuracy_page.format_table(run))[1:],
                         [["gale, shallow", "3 cm", "4 cm", "4 cm", "1.6 cm", "1.5 cm"]])

    def test_octaves_run_from_twice_the_wavenumber_to_itself(self):
        run = run_of({(GALE, "named", "balanced"): {**BALANCED, "energy_pct@0.5": -1.5, "phase_rad@0.5": 0.02,
                                                    "energy_worst_pct@0.5": -3.1, "energy_pct@4": 12, "phase_rad@4": 0.3}})
        self.assertEqual(cells(accuracy_page.octave_table(run))[1:],
                         [["6.28 to 12.6", "-1.5", "-3.1", "0.02"], ["0.785 to 1.57", "12", "-", "0.3"]])
        self.assertIn("whole interval", accuracy_page.octave_moments(run))
        self.assertIn("one moment", accuracy_page.octave_moments(run_of({(GALE, "named", "balanced"): BALANCED})))

    def test_tiles_have_a_stream_and_answers_have_none(self):
        run = run_of({(GALE, "rung", "predicted tiles"): {**BALANCED, "decode_ms_per_s": 6.4},
                      (GALE, "rung", "answers"): dict(BALANCED, rms_m=0.009, bytes_per_s=0, encode_ms_per_s=0)})
        self.assertEqual(cells(accuracy_page.rung_table(run))[1:],
                         [["predicted tiles", "1.1 cm", "3.2 cm", "0.013", "20", "31", "6.4", "1.7"],
                          ["answers", "9 mm", "3.2 cm", "0.013", "-", "-", "-", "1.7"]])
        self.assertIn("all of our clients", accuracy_page.stream_form(run))
        self.assertIn("whole maps", accuracy_page.stream_form(run_of({(GALE, "rung", "tiles"): BALANCED})))

    def test_devices_tell_their_own_clock_and_driver(self):
        run = run_of({(GALE, "device", "vulkan"): {"rms_m": 0.004, "keyframe_cpu_ms_per_s": 2.5, "device_ms_per_s": 14}})
        self.assertEqual(cells(accuracy_page.device_table(run))[1:], [["vulkan", "4 mm", "2.5", "14", "driver of vulkan"]])

    def test_batches_are_microseconds_by_size_and_a_size_without_a_measurement_is_a_dash(self):
        run = run_of({(GALE, "batch", "alone@1"): {"batch_ns": 2100, "batch_difference_m": 0},
                      (GALE, "batch", "alone@10000"): {"batch_ns": 1300, "batch_difference_m": 3e-9},
                      (GALE, "batch", "served@100"): {"batch_ns": 7400, "batch_difference_m": 2e-3}})
        self.assertEqual(cells(accuracy_page.batch_table(run)),
                         [["us an answer, batches of", "1", "100", "10 000"], ["alone", "2.1", "-", "1.3"],
                          ["served", "-", "7.4", "-"]])
        self.assertEqual(accuracy_page.batch_difference(run), "to 2 mm")
        same = run_of({(GALE, "batch", "alone@1"): {"batch_difference_m": 0}})
        self.assertEqual(accuracy_page.batch_difference(same), "to the bit")


class Scenes(unittest.TestCase):
    def test_every_key_of_accuracy_has_a_measurement(self):
        text = (accuracy_page.ROOT / "docs/scenes.md").read_text().split("\n## [accuracy]\n")[1].split("\n## ")[0]
        keys = set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
        self.assertIn("height_error_m", keys)
        self.assertEqual(keys, set(accuracy_page.MEASURED_BY), "a key that costs accuracy is measured: tools/bench/accuracy/knobs.cpp")
        known = set(re.findall(r'Knob\{"(\w+)"', (accuracy_page.ROOT / "tools/bench/accuracy/knobs.cpp").read_text()))
        self.assertLessEqual(set(accuracy_page.MEASURED_BY.values()) - {""}, known)
        # A certificate changes nothing of a sea.
        self.assertEqual([key for key, knob in accuracy_page.MEASURED_BY.items() if not knob], ["certificate"])


class Words(unittest.TestCase):
    def test_each_word_is_the_figure_of_its_name(self):
        named = {name: {metric: figure * factor for metric, figure in BALANCED.items()}
                 for name, factor in (("balanced", 1), ("precise", 2), ("fast", 3), ("query_only", 5),
                                      ("64 largest waves", 7), ("all modes summed", 11))}
        named["balanced"]["truth_error_m"] = 3e-12
        named["query_only"]["spline_ms_per_s"] = 3  # with its keyframes 29 ms, which 2843 answers of 18.7 - 8.5 us cost
        trials = {(GALE, "named", name): figures for name, figures in named.items()}
        trials |= {(state, "named", "balanced"): dict(BALANCED, bound_over_p99=bound)
                   for state, bound in zip([s for s in accuracy_page.STATES if s != GALE], (4.2, 9.4, 5, 7, 8))}
        for rule, gain, memory in (("bilinear", 4, 1.2), ("spline", 20, 1)):
            for doublings in range(4):
                error = (0.2 if rule == "bilinear" else 0.01) / gain ** doublings
                trials[(GALE, "grid", f"{rule}@{64 << doublings}")] = {"rms_m": error, "memory_mb": memory * 4 ** doublings}
        for factor, query_ns, rms_m in (("0", 1000, 0.01), ("0.5", 1500, 0.0103), ("1", 3000, 0.0101), ("1.5", 27000, 0.0102)):
            trials[(GALE, "choppiness", f"factor@{factor}")] = {"query_ns": query_ns, "rms_m": rms_m}
        trials[(GALE, "batch", "exact, one thread@1")] = {"batch_ns": 237e3, "batch_difference_m": 0}
        trials[(GALE, "rung", "predicted tiles")] = {**BALANCED, "decode_ms_per_s": 6.4}
        trials[(GALE, "combination", "256@0.1")] = {"flagged_pct": 3.3, "query_ns": 4400, "p99_m": 0.19}
        with tempfile.TemporaryDirectory() as folder, \
                unittest.mock.patch.object(accuracy_page, "DATA", pathlib.Path(folder)):
            (pathlib.Path(folder) / "note.txt").write_text("Measured twice.\n")
            words = accuracy_page.words([run_of(trials)])
        expected = {
            "BALANCED_P99": "3.2 cm", "BALANCED_RMS": "1.1 cm", "BALANCED_MAPS": "5.2", "BALANCED_ENCODE": "31",
            "BALANCED_ANSWER": "1.7", "BALANCED_WORK": "53", "PRECISE_WORK": "106", "PRECISE_STREAM": "40",
            "QUERY_ONLY_WORK": "265", "FAST_WORK": "159", "FAST_STREAM": "60", "BALANCED_STREAM": "20",
            "BALANCED_MISSING": "2.1 cm", "SUM_ANSWER": "19", "SUM_RATIO": "11", "SUM_WORK": "583", "SUM_EVEN": "2843",
            "GERSTNER_RMS": "7.7 cm",
            "BOUND_OVER_P99": "4.2 to 9.4", "LOOSE_FLAGGED": "3.3", "LOOSE_ANSWER": "4.4", "LOOSE_P99": "19 cm",
            "TRUTH": "3e-12 m", "SETTINGS": "seaway-bench accuracy, seed 7", "MACHINE": "a machine", "COMMIT": "abc1234",
            "NOTE": "Measured twice. ", "OTHER_HEADLINES": "",
            "SPLINE_GAIN": "20", "BILINEAR_GAIN": "4", "BILINEAR_ERROR": "20", "BILINEAR_MEMORY": "1.2",
            "BILINEAR_FINE_ERROR": "1.2", "BILINEAR_FINE_MEMORY": "19", "FAST_SHARE": "3", "PRECISE_TIMES": "2",
            "CHOPPY_TIMES": "3", "FOLDING_TIMES": "27", "CHOPPY_SPREAD": "3", "SUM_ALONE": "237"}
        for word, text in expected.items():
            self.assertEqual(words[word], text, word)
        tables = {"RUNGS", "STREAM_FORM", "OCTAVE_MOMENTS", "WAYS", "STATES", "LAWS", "FORMATS", "OCTAVES", "DEVICES", "BATCHES", "BATCH_DIFFERENCE"}
        self.assertEqual(set(words), set(expected) | tables)

    def test_another_device_is_told_by_its_own_figures(self):
        other = run_of({(GALE, "named", "balanced"): dict(BALANCED, rms_m=0.013, keyframe_cpu_ms_per_s=88)},
                       "llvmpipe (LLVM)")
        text = accuracy_page.lavapipe_words([run_of({(GALE, "named", "balanced"): BALANCED}), other])
        for part in ("accuracy_headline_lavapipe.png", "llvmpipe (LLVM): balanced has an rms of 1.3 cm",
                     "cost 88 ms", "seed 7", "abc1234"):
            self.assertIn(part, text)

    def test_a_trial_that_was_stopped_is_none(self):
        path = run_of({(GALE, "named", "balanced"): BALANCED}).path
        text = path.read_text()
        unfinished = f"{GALE},named,fast,rms_m,1,1,1,native,d,m,c\n"
        path.write_text(text + unfinished)
        self.assertIsNone(accuracy_page.Run(path).figure(GALE, "named", "fast", "rms_m"))

    def test_measurements_are_kept_by_device_and_the_map_of_errors_is_the_native_one(self):
        native, other = (run_of({(GALE, "named", "balanced"): BALANCED}, device)
                         for device in ("native (x)", "NVIDIA L4 (570)"))
        with tempfile.TemporaryDirectory() as folder, \
                unittest.mock.patch.object(accuracy_page, "DATA", pathlib.Path(folder)):
            for run, text in ((native, "of native"), (other, "of another")):
                (run.path.parent / "error_map.csv").write_text(text)
            accuracy_page.take([other.path.parent, native.path.parent], "A note.")
            names = sorted(path.name for path in pathlib.Path(folder).iterdir())
            self.assertEqual(names, ["error_map.csv", "native.csv", "note.txt", "nvidia_l4_570.csv"])
            self.assertEqual((pathlib.Path(folder) / "error_map.csv").read_text(), "of native")
            self.assertEqual((pathlib.Path(folder) / "note.txt").read_text(), "A note.\n")
            self.assertEqual([run.device for run in accuracy_page.runs()], ["native", "nvidia_l4_570"])


class Drawn:
    """Axes that remember what is drawn on them."""

    def __init__(self, count):
        self.axes = [unittest.mock.MagicMock() for _ in range(count)]
        for axis in self.axes:
            axis.get_lines.return_value = []
        accuracy_pictures.plt.subplots = unittest.mock.MagicMock(
            return_value=(unittest.mock.MagicMock(), self.axes))
        accuracy_pictures.save.digest = "0"


class Pictures(unittest.TestCase):
    def test_the_front_is_of_points_that_no_other_beats_in_error_and_in_work(self):
        points = [(0.1, 5), (0.01, 50), (0.02, 60), (0.05, 20), (0.2, 9), (0.3, 2), (0.05, 30)]
        self.assertEqual(accuracy_pictures.front(points), [(0.01, 50), (0.05, 20), (0.1, 5), (0.3, 2)])

    def test_a_sheet_shows_measured_with_its_interval_expected_dashed_and_what_it_costs(self):
        run = run_of({(GALE, "interval", "hermite@2"): {"rms_m": (0.4, 0.3, 0.6), "predicted_rms_m": 0.5, "cost": 3},
                      (GALE, "interval", "hermite@1"): {"rms_m": (0.1, 0.09, 0.15), "predicted_rms_m": 0.12, "cost": 7}})
        drawn = Drawn(2)
        accuracy_pictures.sheet(run, "interval", "x.png", "interval, s", "cost", "ms", "K8")
        left, right = drawn.axes
        (xs, ys), style = left.errorbar.call_args
        self.assertEqual((xs, ys), ([1, 2], [0.1, 0.4]))
        for found, expected in zip(style["yerr"], ([0.01, 0.1], [0.05, 0.2])):
            for a, b in zip(found, expected):
                self.assertAlmostEqual(a, b)
        expected_line, dashes = left.plot.call_args
        self.assertEqual(expected_line, ((1, 2), (0.12, 0.5)))
        self.assertEqual(dashes["ls"], "--")
        self.assertEqual(right.plot.call_args[0], ((1, 2), (7, 3)))
        left.set_ylabel.assert_called_with("rms error of height, m")
        right.set_ylabel.assert_called_with("ms")

    def test_knobs_together_stand_beside_what_was_expected_and_hands_beside_budgets(self):
        run = run_of({(GALE, "combination", "128@0.01"): {"rms_m": 0.003, "predicted_rms_m": 0.004, "work_ms_per_s": 40},
                      (GALE, "combination", "256@0.03"): {"rms_m": 0.009, "predicted_rms_m": 0.01, "work_ms_per_s": 30},
                      (GALE, "combination", "128, 0.5 s@0.03"): {"rms_m": 0.02, "predicted_rms_m": 0.03,
                                                                  "work_ms_per_s": 50}})
        drawn = Drawn(2)
        accuracy_pictures.together(run, "x.png")
        left, right = drawn.axes
        for number, (label, expected, errors, work) in enumerate((
                ("by a budget", [0.004, 0.01], [0.003, 0.009], [40, 30]), ("by hand", [0.03], [0.02], [50]))):
            self.assertEqual(left.scatter.call_args_list[number][0], (expected, errors))
            self.assertEqual(left.scatter.call_args_list[number][1]["label"], label)
            self.assertEqual(right.scatter.call_args_list[number][0], (errors, work))

    def test_a_batch_reaches_from_its_fastest_round_to_its_slowest(self):
        run = run_of({(GALE, "batch", "alone@10"): {"batch_ns": (3000, 2500, 4500), "batch_ms": (0.03, 0.025, 0.045)}})
        drawn = Drawn(2)
        accuracy_pictures.batches(run, "x.png")
        for axis, middle, below, above in ((drawn.axes[0], 3, 0.5, 1.5), (drawn.axes[1], 0.03, 0.005, 0.015)):
            (xs, ys), style = axis.errorbar.call_args
            self.assertEqual(xs, [10])
            self.assertAlmostEqual(ys[0], middle)
            self.assertAlmostEqual(style["yerr"][0][0], below)
            self.assertAlmostEqual(style["yerr"][1][0], above)


if __name__ == "__main__":
    unittest.main()

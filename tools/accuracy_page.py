#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/accuracy.md, its sentence in README.md and docs/pictures/accuracy_*.png from the measurements in
docs/accuracy, which `seaway-bench accuracy` made.

    tools/accuracy_page.py [--text]                          draws again what docs/accuracy holds
    tools/accuracy_page.py --take FOLDER ... [--note TEXT]   first puts new measurements there

A FOLDER is what `--out` of the bench was. Its accuracy.csv becomes docs/accuracy/native.csv, lavapipe.csv or
that of another device, its error_map.csv goes beside it; a device that is not given stays as it is. The page
speaks of the native one, each other adds its headline plot. Pictures need python3-matplotlib (apt install
python3-matplotlib), the text (--text) does not. tools/check_accuracy.py holds that page and pictures are of
the measurements beside them.

To measure all of it again, on a quiet machine (2 cores: some 20 minutes; with --points 512 --times 8 in each command 5):

    build/dev/bin/seaway-bench accuracy --quick --points 4096 --times 32 --out out/bench/accuracy
    build/dev/bin/seaway-server scenes/north_sea_gale.toml --listen 127.0.0.1:9431 & sleep 5
    build/dev/bin/seaway-bench accuracy --quick --points 4096 --times 32 --knobs batch --server ws://127.0.0.1:9431 --out out/bench/accuracy
    kill %1
    build/dev/bin/seaway-bench accuracy --quick --points 4096 --times 32 --device llvmpipe --states gale_deep --knobs named,combination \
        --out out/bench/accuracy_lavapipe
    tools/accuracy_page.py --take out/bench/accuracy out/bench/accuracy_lavapipe

A run that was stopped goes on; one of another commit wants another folder, or an empty one.
"""
import argparse
import csv
import pathlib
import re
import shutil
import zlib

from page_text import filled, metres, number, table

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT / "docs/accuracy"
PAGE = ROOT / "docs/accuracy.md"
README = ROOT / "README.md"
PICTURES = ROOT / "docs/pictures"
MAIN = "native"
GALE = "gale_deep"
STATES = ["calm_deep", "calm_shallow", "gale_deep", "gale_shallow", "storm_deep", "storm_shallow"]
PRESETS = ["precise", "balanced", "fast", "query_only"]
BASELINES = ["250/17/5 m of 256", "one tile of 512", "64 largest waves", "all modes summed"]
# What is held to a factor of two, and below which error float maps, not the knob, decide (m).
LAWS = [
    ("K1", "cutoff", "waves above a wavenumber left out", 0),
    ("K2", "grid", "grid points a wave, bilinear and cubic spline", 1e-6),
    ("K5", "format", "maps of 16 bits", 0),
    ("K7", "phase", "phases in single precision", 1e-6),
    ("K8", "interval", "keyframe interval: Hermite, linear, hold", 0),
    ("K9", "codec", "the codec's bound", 0),
    ("K10", "inverse fixed point", "fixed-point steps of the inverse", 0),
    ("K11", "modes", "only the largest waves summed", 1e-6),
    ("K14", "latency", "answers of a while ago", 0),
    ("", "combination", "grid, interval and codec together", 0),
]

# Which measurement says what a key of a scene's [accuracy] costs, by the names of tools/bench/accuracy/knobs.cpp.
MEASURED_BY = {"preset": "named", "height_error_m": "combination", "certificate": ""}

HEADLINE = """\
In a gale the balanced preset is off by {{BALANCED_P99}} at the 99th percentile, and the waves that its grid leaves out carry
{{BALANCED_MISSING}}: that costs {{BALANCED_MAPS}} ms of CPU a second for maps, {{BALANCED_ENCODE}} ms for a stream that all clients share, and
{{BALANCED_ANSWER}} us an answer; the sum of all waves takes {{SUM_RATIO}} times as long.
"""


class Run:
    """One accuracy.csv: figures by state, knob and value."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        lines = self.path.read_text().splitlines()
        self.settings = lines[0].lstrip("# ")
        self.trials = {}
        self.places = {}
        done = set()
        for row in csv.DictReader(lines[1:]):
            key = (row["state"], row["knob"], row["value"])
            self.trials.setdefault(key, {})[row["metric"]] = tuple(
                float(row[c]) for c in ("figure", "ci_low", "ci_high"))
            self.places[key] = row
            if row["metric"] == "done":
                done.add(key)
        self.trials = {key: figures for key, figures in self.trials.items() if key in done}
        self.place = self.places[next(iter(self.trials))]

    @property
    def device(self):
        """A word for it: of a file, and of a picture."""
        name = self.place["device"]
        if name.startswith("native"):
            return MAIN
        return "lavapipe" if "llvmpipe" in name else re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")

    def figure(self, state, knob, value, metric):
        """None where it was not measured."""
        figures = self.trials.get((state, knob, value), {})
        return figures[metric][0] if metric in figures else None

    def values(self, state, knob):
        return [value for (s, k, value) in self.trials if (s, k) == (state, knob)]

    def curves(self, state, knob):
        """{curve: [(x, value), ...]} of values named curve@x."""
        found = {}
        for value in self.values(state, knob):
            name, _, x = value.rpartition("@")
            found.setdefault(name, []).append((float(x), value))
        return {name: sorted(points) for name, points in found.items()}

    def worst(self, value, metric):
        """The largest over the states in which a named configuration was measured, and over the seeds."""
        found = [self.trials[(state, "named", value)] for state in STATES if (state, "named", value) in self.trials]
        of_seeds = metric.replace("_m", "_worst_m")
        return max((figures.get(of_seeds, figures[metric])[0] for figures in found), default=None)


def runs():
    """Of all devices that docs/accuracy holds, the page's own first."""
    paths = sorted(DATA.glob("*.csv"), key=lambda path: (path.stem != MAIN, path.stem))
    return [Run(path) for path in paths if path.stem != "error_map"]


def digest():
    """Of all that pictures show; they carry it."""
    return f"{zlib.crc32(b''.join(path.read_bytes() for path in sorted(DATA.glob('*.csv')))):08x}"


def take(folders, note):
    """Puts measurements into docs/accuracy."""
    DATA.mkdir(exist_ok=True)
    for folder in map(pathlib.Path, folders):
        device = Run(folder / "accuracy.csv").device
        shutil.copyfile(folder / "accuracy.csv", DATA / f"{device}.csv")
        if device == MAIN and (folder / "error_map.csv").exists():
            shutil.copyfile(folder / "error_map.csv", DATA / "error_map.csv")
    (DATA / "note.txt").write_text(note + "\n" if note else "")


def seas_measured(run):
    """In words: what "worst" is over."""
    seeds = sum(metric.startswith("p99_m@seed=") for metric in run.trials[(GALE, "named", "balanced")])
    states = sum((state, "named", "balanced") in run.trials for state in STATES)
    return f"{states} seas" if seeds < 2 else f"{states} seas, {seeds} seeds each"


def ways_table(run):
    rows = []
    for name in PRESETS + BASELINES:
        get = lambda metric: run.figure(GALE, "named", name, metric)
        if get("rms_m") is None:
            continue
        rows.append([
            f"**{name}**" if name in PRESETS else name,
            metres(get("rms_m")), metres(get("p99_m")), metres(run.worst(name, "p99_m")),
            metres(get("crest_m")) if (get("crest_m") or 0) >= 0 else "-" + metres(-get("crest_m")),
            number(get("slope_rms")), metres(get("missing_rms_m")),
            number(get("keyframe_cpu_ms_per_s")), number(get("encode_ms_per_s")) if get("bytes_per_s") else "-",
            number(get("query_ns") / 1e3), number(get("work_ms_per_s")),
            number(get("bytes_per_s") * 8e-6) if get("bytes_per_s") else "-", number(get("memory_mb")),
            number(get("flagged_pct"))])
    return table(["", "rms", "p99", f"p99, worst of {seas_measured(run)}", "mean at crests", "slope rms", "waves left out",
                  "maps, ms/s", "encoding, ms/s", "an answer, us", "work, ms/s", "Mbit/s", "MB",
                  "flagged, %"], rows)


def states_table(run):
    rows = []
    for state in STATES:
        get = lambda metric: run.figure(state, "named", "balanced", metric)
        if get("rms_m") is None:
            continue
        rows.append([state.replace("_", ", "), f"{get('hs_m'):.2g} m", metres(get("rms_m")), metres(get("p99_m")),
                     metres(get("max_m")), f"{get('p99_pct_hs'):.2g}", number(get("normal_p99_deg")),
                     number(get("velocity_rms_mps")), metres(get("flicker_m")), metres(get("missing_rms_m")),
                     number(get("bound_over_p99")), number(get("folded_pct"))])
    return table(["sea", "Hs", "rms", "p99", "largest", "p99, % of Hs", "normal p99, deg", "velocity rms, m/s",
                  "flicker", "waves left out", "stated bound / p99", "folded, %"], rows)


def law_table(run):
    rows = []
    for number_, knob, what, floor in LAWS:
        name, _, curve = knob.partition(" ")
        ratios, predicted = [], []
        for (_, k, value), figures in run.trials.items():
            if k != name or not value.startswith(curve) or "predicted_rms_m" not in figures:
                continue
            law = figures["predicted_rms_m"][0]
            if law > floor and law > 0:
                ratios.append(figures["rms_m"][0] / law)
                predicted.append(law)
        if not ratios:
            continue
        rows.append([number_, what, str(len(ratios)), f"{metres(min(predicted))} to {metres(max(predicted))}",
                     f"{min(ratios):.2f} to {max(ratios):.2f}",
                     "yes" if 0.5 <= min(ratios) and max(ratios) <= 2 else "see below"])
    return table(["", "knob", "points", "expected rms", "measured / expected", "within 2"], rows)


def format_table(run):
    rows = []
    for state in STATES:
        get = lambda form, metric: run.figure(state, "format", form, metric)
        if get("f16", "rms_m") is None:
            continue
        added = lambda form: max(get(form, "rms_m") ** 2 - get("f32", "rms_m") ** 2, 0) ** 0.5
        rows.append([state.replace("_", ", "), metres(get("f32", "rms_m")), metres(added("f16")),
                     metres(get("f16", "predicted_format_m")), metres(added("snorm16")),
                     metres(get("snorm16", "predicted_format_m"))])
    return table(["sea", "f32, all sources", "f16 adds", "expected", "snorm16 adds", "expected"], rows)


def octave_table(run, value="balanced", knob="named"):
    figures = run.trials.get((GALE, knob, value), {})
    rows = []
    for metric, figure in figures.items():
        if metric.startswith("energy_pct@"):
            k = float(metric.split("@")[1])
            phase = figures[f"phase_rad@{metric.split('@')[1]}"][0]
            worst = figures.get(f"energy_worst_pct@{metric.split('@')[1]}", [None])[0]
            rows.append([f"{6.283 / (2 * k):.3g} to {6.283 / k:.3g}", f"{figure[0]:.2g}", number(worst), f"{phase:.1g}"])
    return table(["wavelength, m", "energy, %", "at the worst moment, %", "phase, rad"], rows)


def octave_moments(run):
    """Of figures from before there were several moments: at which they were."""
    several = any(metric.startswith("energy_worst_pct@") for metric in run.trials.get((GALE, "named", "balanced"), {}))
    return ", over a whole interval between keyframes" if several else \
        ", at one moment, which was a keyframe of the shortest tile: between keyframes its waves lose more"


def rung_table(run):
    rows = []
    for value in run.values(GALE, "rung"):
        get = lambda metric: run.figure(GALE, "rung", value, metric)
        rows.append([value, metres(get("rms_m")), metres(get("p99_m")), number(get("slope_rms")),
                     *(number(get(metric) * scale) if get("bytes_per_s") else "-"
                       for metric, scale in (("bytes_per_s", 8e-6), ("encode_ms_per_s", 1), ("decode_ms_per_s", 1))),
                     number(get("query_ns") / 1e3)])
    return table(["", "rms", "p99", "slope rms", "Mbit/s", "encoding, ms/s", "a client's taking, ms/s", "an answer, us"], rows)


def stream_form(run):
    """Of what its streams are."""
    if "predicted tiles" in run.values(GALE, "rung"):
        return "Streams are of heights and their rates as differences to what follows from the keyframe before, which is what all of our clients take."
    return "Streams are of whole maps of six fields, each coded alone: what our clients take (`seaway-bench line`) is a hundredth of that."


def ratio(run, metric, first, second):
    """Of two trials in the gale, each (knob, value)."""
    return run.figure(GALE, *first, metric) / run.figure(GALE, *second, metric)


def ratio_words(run):
    """What the text says of one thing beside another."""
    bilinear, spline = (lambda size, rule=rule: ("grid", f"{rule}@{size}") for rule in ("bilinear", "spline"))
    gain = lambda rule: ratio(run, "rms_m", rule(64), rule(512)) ** (1 / 3)
    stream = lambda name: ratio(run, "bytes_per_s", ("named", name), ("named", "balanced"))
    choppy = lambda factor: ("choppiness", f"factor@{factor}")
    errors = [run.figure(GALE, *choppy(factor), "rms_m") for factor in ("0", "0.5", "1", "1.5")]
    return {
        "SPLINE_GAIN": number(gain(spline)), "BILINEAR_GAIN": number(gain(bilinear)),
        "BILINEAR_ERROR": number(ratio(run, "rms_m", bilinear(64), spline(64))),
        "BILINEAR_MEMORY": number(ratio(run, "memory_mb", bilinear(64), spline(64))),
        "BILINEAR_FINE_ERROR": number(ratio(run, "rms_m", bilinear(256), spline(64))),
        "BILINEAR_FINE_MEMORY": number(ratio(run, "memory_mb", bilinear(256), spline(64))),
        "FAST_SHARE": number(stream("fast")), "PRECISE_TIMES": number(stream("precise")),
        "CHOPPY_TIMES": number(ratio(run, "query_ns", choppy("1"), choppy("0"))),
        "FOLDING_TIMES": number(ratio(run, "query_ns", choppy("1.5"), choppy("0"))),
        "CHOPPY_SPREAD": number(100 * (max(errors) / min(errors) - 1)),
        "SUM_ALONE": number(run.figure(GALE, "batch", "exact, one thread@1", "batch_ns") / 1e3),
    }


def device_table(run):
    rows = []
    for value in run.values(GALE, "device"):
        get = lambda metric: run.figure(GALE, "device", value, metric)
        rows.append([value, metres(get("rms_m")), number(get("keyframe_cpu_ms_per_s")), number(get("device_ms_per_s")),
                     run.places[(GALE, "device", value)]["driver"]])
    return table(["device", "rms", "CPU, ms/s", "by its own clock, ms/s", "driver"], rows)


def batch_table(run):
    """K12: microseconds an answer by how many are asked for at once."""
    curves = run.curves(GALE, "batch")
    sizes = sorted({x for points in curves.values() for x, _ in points})
    rows = []
    for name, points in curves.items():
        each = {x: run.figure(GALE, "batch", value, "batch_ns") for x, value in points}
        rows.append([name] + [number(each[x] / 1e3) if x in each else "-" for x in sizes])
    return table(["us an answer, batches of"] + [f"{size:,.0f}".replace(",", " ") for size in sizes], rows)


def batch_difference(run):
    """The largest over all batches, in words."""
    found = [figures["batch_difference_m"][0] for figures in run.trials.values() if "batch_difference_m" in figures]
    return "to the bit" if not any(found) else f"to {metres(max(found))}"


def lavapipe_words(all_runs):
    """The headline plots of the other devices."""
    words = []
    for run in all_runs[1:]:
        get = lambda metric: run.figure(GALE, "named", "balanced", metric)
        words.append(f"![Error against work on {run.device}](pictures/accuracy_headline_{run.device}.png)\n\n"
                     f"{run.place['device']}: balanced has an rms of {metres(get('rms_m'))} there too, and its maps cost "
                     f"{number(get('keyframe_cpu_ms_per_s'))} ms of CPU a second; {run.settings}; commit {run.place['commit']}.")
    return "\n\n".join(words)


def bound_range(run):
    ratios = [run.figure(state, "named", "balanced", "bound_over_p99") for state in STATES]
    return f"{min(ratios):.1f} to {max(ratios):.1f}"


def words(all_runs):
    run = all_runs[0]
    get = lambda name, metric: run.figure(GALE, "named", name, metric)
    loose = lambda metric: run.figure(GALE, "combination", "256@0.1", metric)
    return {
        **ratio_words(run), "STREAM_FORM": stream_form(run), "OCTAVE_MOMENTS": octave_moments(run), "RUNGS": rung_table(run),
        "WAYS": ways_table(run), "STATES": states_table(run), "LAWS": law_table(run),
        "FORMATS": format_table(run), "OCTAVES": octave_table(run), "DEVICES": device_table(run),
        "BATCHES": batch_table(run), "BATCH_DIFFERENCE": batch_difference(run),
        "OTHER_HEADLINES": lavapipe_words(all_runs),
        "BALANCED_P99": metres(get("balanced", "p99_m")), "BALANCED_RMS": metres(get("balanced", "rms_m")),
        "BALANCED_MAPS": number(get("balanced", "keyframe_cpu_ms_per_s")),
        "BALANCED_ENCODE": number(get("balanced", "encode_ms_per_s")),
        "BALANCED_ANSWER": number(get("balanced", "query_ns") / 1e3),
        "BALANCED_WORK": number(get("balanced", "work_ms_per_s")),
        "PRECISE_WORK": number(get("precise", "work_ms_per_s")),
        "PRECISE_STREAM": number(get("precise", "bytes_per_s") * 8e-6),
        "QUERY_ONLY_WORK": number(get("query_only", "work_ms_per_s")),
        "FAST_WORK": number(get("fast", "work_ms_per_s")),
        "FAST_STREAM": number(get("fast", "bytes_per_s") * 8e-6),
        "BALANCED_STREAM": number(get("balanced", "bytes_per_s") * 8e-6),
        "BALANCED_MISSING": metres(get("balanced", "missing_rms_m")),
        "SUM_ANSWER": number(get("all modes summed", "query_ns") / 1e3),
        "SUM_RATIO": number(get("all modes summed", "query_ns") / get("balanced", "query_ns")),
        "SUM_WORK": number(get("all modes summed", "work_ms_per_s")), "SUM_EVEN": f"{exact_even(run):.0f}",
        "GERSTNER_RMS": metres(get("64 largest waves", "rms_m")),
        "BOUND_OVER_P99": bound_range(run),
        "LOOSE_FLAGGED": number(loose("flagged_pct")),
        "LOOSE_ANSWER": number(loose("query_ns") / 1e3),
        "LOOSE_P99": metres(loose("p99_m")),
        "TRUTH": f"{max(f['truth_error_m'][0] for f in run.trials.values() if 'truth_error_m' in f):.1g} m",
        "SETTINGS": run.settings, "MACHINE": run.place["machine"], "COMMIT": run.place["commit"],
        "NOTE": ((DATA / "note.txt").read_text().strip() + " ").lstrip(),
    }


def exact_even(run):
    """So many exact answers a second cost what the maps of `query_only` and as many of its answers do."""
    get = lambda name, metric: run.figure(GALE, "named", name, metric)
    maps_ms = get("query_only", "keyframe_cpu_ms_per_s") + get("query_only", "spline_ms_per_s")
    return maps_ms * 1e6 / (get("all modes summed", "query_ns") - get("query_only", "query_ns"))


def asked_for(template, all_words):
    return {word: text for word, text in all_words.items() if "{{" + word + "}}" in template}


def page():
    """The text of docs/accuracy.md."""
    template = (ROOT / "tools/accuracy_page.md.in").read_text()
    return filled(template, asked_for(template, words(runs())))


def readme():
    """README.md with the page's sentence."""
    before, begin, rest = README.read_text().partition("<!-- written by tools/accuracy_page.py -->\n")
    _, end, after = rest.partition("<!-- until here -->\n")
    return before + begin + filled(HEADLINE, asked_for(HEADLINE, words(runs()))) + end + after


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--take", nargs="+", metavar="FOLDER", help="puts these measurements into docs/accuracy")
    parser.add_argument("--note", default="", help="with --take: a sentence about this run, for the page's end")
    parser.add_argument("--text", action="store_true", help="no pictures")
    options = parser.parse_args()
    if options.take:
        take(options.take, options.note)
    if not options.text:
        import accuracy_pictures
        accuracy_pictures.draw_all(runs(), PICTURES, digest())
    PAGE.write_text(page())
    README.write_text(readme())


if __name__ == "__main__":
    main()

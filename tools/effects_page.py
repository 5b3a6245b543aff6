#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/effects.md from the CSV files in docs/effects, and with --pictures docs/pictures/effects_*.png
(which needs python3-matplotlib). `--measure BUILD` takes the CSV files anew first: some minutes, and a minute
of a real server.
"""
import argparse
import csv
import pathlib
import shutil
import subprocess
from math import fsum  # the same with every version of Python: sum() adds up more carefully from 3.12 on

from page_text import filled, number, table

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT / "docs/effects"
PAGE = ROOT / "docs/effects.md"
EFFECTS = ["height", "choppy", "slopes", "gradient", "foam"]
# What is measured: file, its name on the page, scene, what is asked of it, extra arguments.
SCENES = [
    ("pond", "a pond", "docs/effects/pond.toml", []),
    ("gale", "a gale", "scenes/north_sea_gale.toml", ["--ask", "height,choppy,slopes,foam"]),
    ("film_shot", "a film shot", "docs/effects/film_shot.toml", []),
]
COUNTS = ["keyframes", "transforms", "maps_ms", "stream_ms", "kilobytes"]


class Costs:
    """One effects.csv: rows of numbers for a second of sea."""

    def __init__(self, path):
        lines = path.read_text().splitlines()
        self.note = lines[0].lstrip("# ")
        self.place = self.note.split(" on ", 1)[1]
        self.rows = [{**row, **{k: float(row[k]) for k in row if k not in ("what", "effect", "cascade")}}
                     for row in csv.DictReader(line for line in lines if not line.startswith("#"))]

    def row(self, what):
        return next(row for row in self.rows if row["what"] == what)

    def cascades(self):
        return [row for row in self.rows if row["what"] == "cascade"]

    def effect(self, effect, cascade):
        return next(row for row in self.rows if (row["effect"], row["cascade"]) == (effect, cascade))

    def work(self, row, prefix=""):
        """Maps and stream, ms of CPU a second."""
        return row[prefix + "maps_ms"] + row[prefix + "stream_ms"]

    def of_effect(self, effect, column):
        return fsum(self.effect(effect, c["cascade"])[column] for c in self.cascades())


class Minute:
    """demand.csv: counters of transforms over time."""

    def __init__(self, path):
        lines = path.read_text().splitlines()
        self.guests = []
        for line in lines:
            if line.startswith("# guest: "):
                span, name = line[len("# guest: "):].split(" s, ", 1)
                self.guests.append((name, *(float(t) for t in span.split(" to "))))
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
        self.columns = rows[0][2:]
        self.times = [float(row[0]) for row in rows[1:]]
        self.sessions = [int(row[1]) for row in rows[1:]]
        self.counts = {name: [float(row[i + 2]) for row in rows[1:]] for i, name in enumerate(self.columns)}

    def total(self, at):
        return sum(counts[at] for counts in self.counts.values())

    def rate(self, start, end, of=""):
        """Transforms a second between two times; of columns that hold this text."""
        inside = [i for i, t in enumerate(self.times) if start - 0.25 <= t <= end + 0.25]
        first, last = inside[0], inside[-1]
        grown = sum(c[last] - c[first] for name, c in self.counts.items() if of in name)
        return grown / (self.times[last] - self.times[first])


def cell(value):
    return "0" if abs(value) < 0.005 else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"


def scenes_table(costs):
    rows = []
    for file, name, _, _ in SCENES:
        asked, everything = costs[file].row("asked"), costs[file].row("everything")
        for title, row in ((asked["effect"].replace(" ", ", "), asked), ("*everything*", everything)):
            work = costs[file].work(row)
            rows.append([f"**{name}**" if row is asked else "", title, number(row["transforms"], 3), cell(row["maps_ms"]),
                         cell(row["stream_ms"]), cell(row["kilobytes"]),
                         "1" if row is asked else number(work / costs[file].work(asked), 3)])
    return table(["", "what runs", "transforms/s", "maps, ms/s", "stream, ms/s", "kB/s", "work, times"], rows)


def marginal_table(cost):
    cascades = cost.cascades()
    rows = []
    for effect in EFFECTS:
        cells = [cost.effect(effect, c["cascade"]) for c in cascades]
        rows.append([effect] + [f"{cell(r['more_maps_ms'])} + {cell(r['more_stream_ms'])}" for r in cells] +
                    [cell(fsum(cost.work(r, "more_") for r in cells)), cell(fsum(r["more_kilobytes"] for r in cells)),
                     number(fsum(r["more_transforms"] for r in cells), 3)])
    shared = [{k: c[k] - fsum(cost.effect(e, c["cascade"])["more_" + k] for e in EFFECTS) for k in COUNTS} for c in cascades]
    rows.append(["shared by foam and gradient"] + [f"{cell(s['maps_ms'])} + {cell(s['stream_ms'])}" for s in shared] +
                [cell(fsum(cost.work(s) for s in shared)), cell(fsum(s["kilobytes"] for s in shared)),
                 number(fsum(s["transforms"] for s in shared), 3)])
    rows.append(["**all of a cascade**"] + [f"**{cell(c['maps_ms'])} + {cell(c['stream_ms'])}**" for c in cascades] +
                [cell(fsum(cost.work(c) for c in cascades)), cell(fsum(c["kilobytes"] for c in cascades)),
                 number(fsum(c["transforms"] for c in cascades), 3)])
    rows.append(["keyframes/s"] + [number(c["keyframes"], 3) for c in cascades] + ["", "", ""])
    return table(["", *[c["cascade"] for c in cascades], "all tiles, ms/s", "kB/s", "transforms/s"], rows)


def words(costs, minute):
    gale, film, pond = costs["gale"], costs["film_shot"], costs["pond"]
    everything = gale.work(gale.row("everything"))
    buoy, hulls, viewer, second, strains = minute.guests
    steady = minute.rate(second[1] + 1.5, strains[1] - 1)
    return {
        "SCENES": scenes_table(costs),
        "POND": marginal_table(pond), "GALE": marginal_table(gale), "FILM": marginal_table(film),
        "POND_TIMES": number(pond.work(pond.row("everything")) / pond.work(pond.row("asked")), 2),
        "GALE_SAVED": number(100 * (1 - gale.work(gale.row("asked")) / everything), 2),
        "FILM_WORK": number(film.work(film.row("everything")), 3),
        "HEIGHT_SHARE": number(100 * gale.of_effect("height", "more_maps_ms") / gale.row("everything")["maps_ms"], 2),
        "FOAM_SHARE": number(100 * gale.of_effect("foam", "more_maps_ms") / gale.row("everything")["maps_ms"], 2),
        "STREAM_SHARE": number(100 * gale.row("everything")["stream_ms"] / everything, 2),
        "GRADIENT_SHARE": number(100 * gale.of_effect("gradient", "more_stream_ms") / gale.row("everything")["stream_ms"], 2),
        "SHORTEST_SHARE": number(100 * gale.work(gale.cascades()[-1]) / everything, 2),
        "SUM_OFF": number(100 * abs(fsum(gale.work(c) for c in gale.cascades()) / everything - 1), 1),
        "BUOY_RATE": number(minute.rate(buoy[1] + 2, hulls[1] - 1), 3),
        "HULLS_RATE": number(minute.rate(hulls[1] + 2, viewer[1] - 1), 3),
        "SECOND_BEFORE": number(minute.rate(viewer[1] + 4, second[1] - 0.5), 3), "SECOND_AFTER": number(steady, 3),
        "STRAINS_RATE": number(minute.rate(strains[1] + 1.5, strains[2] - 1), 3),
        "BEFORE": number(minute.total(max(i for i, t in enumerate(minute.times) if t < buoy[1])), 3),
        "AFTER": number(minute.rate(buoy[2] + 1.5, minute.times[-1]), 3),
        "FOAM_START": number(minute.rate(viewer[1], viewer[1] + 1.5, "foam"), 3),
        "MACHINE": gale.place,
    }


def page():
    costs = {file: Costs(DATA / f"{file}.csv") for file, *_ in SCENES}
    template = (ROOT / "tools/effects_page.md.in").read_text()
    return filled(template, words(costs, Minute(DATA / "demand.csv")))


def measure(build):
    programs = pathlib.Path(build).resolve() / "bin"
    folder = ROOT / "out/bench/effects"
    for file, _, scene, arguments in SCENES:
        subprocess.run([programs / "seaway-bench", "effects", "--device", "native", "--scene", scene, "--out", folder / file,
                        *arguments], cwd=ROOT, check=True)
    for file, *_ in SCENES:  # after all are measured: each says of which commit it is, and that the tree was clean
        shutil.copy(folder / file / "effects.csv", DATA / f"{file}.csv")
    subprocess.run([ROOT / "tools/demand_minute.py", programs / "seaway-server", DATA / "demand.csv"], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measure", metavar="BUILD", help="a build folder, as build/dev")
    parser.add_argument("--pictures", action="store_true", help="draw them too")
    options = parser.parse_args()
    if options.measure:
        measure(options.measure)
    PAGE.write_text(page())
    if options.pictures:
        import effects_pictures
        effects_pictures.draw_all({file: (name, Costs(DATA / f"{file}.csv")) for file, name, _, _ in SCENES},
                                  Minute(DATA / "demand.csv"), ROOT / "docs/pictures")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""The plots of docs/accuracy.md, from runs as tools/accuracy_page.py reads them."""
import csv

from plot_style import COLOURS, plt

GALE = "gale_deep"
OURS, THEIRS = COLOURS[0], COLOURS[1]
PRESETS = ["precise", "balanced", "fast", "query_only"]


def save(figure, path):
    """With the digest of what it shows, by which tools/check_accuracy.py knows it."""
    figure.savefig(path, metadata={"Description": f"docs/accuracy {save.digest}"})
    plt.close(figure)


def error_axis(axis, label):
    axis.set_xscale("log")
    axis.invert_xaxis()
    axis.set_xlabel(label)


def front(points):
    """The points that nothing beats in both."""
    best, kept = float("inf"), []
    for error, work in sorted(points):
        if work < best:
            best = work
            kept.append((error, work))
    return kept


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def label_points(figure, axis, named):
    """Names beside their points, moved up or down until none covers another, or a point."""
    figure.canvas.draw()
    frame = axis.get_window_extent()
    taken = []  # left, low, right, high
    for point, _ in named.values():
        x, y = axis.transData.transform(point)
        taken.append((x - 5, y - 5, x + 5, y + 5))
    for name, (point, colour) in sorted(named.items(), key=lambda item: -item[1][0][1]):
        inside = axis.transAxes.inverted().transform(axis.transData.transform(point))
        for left, down in ((left, down) for down in (-3, 6, -12, 16, -22, 26, -32) for left in (inside[0] > 0.62, inside[0] <= 0.62)):
            text = axis.annotate(name, point, xytext=(-7 if left else 7, down), textcoords="offset points",
                                 ha="right" if left else "left", fontsize=8, color=colour)
            box = text.get_window_extent().extents
            if box[0] >= frame.x0 and box[2] <= frame.x1 and not any(overlap(box, other) for other in taken):
                taken.append(box)
                break
            text.remove()


def headline(run, path):
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.8), sharey=True)
    panels = [("rms_m", "rms error against the same waves, m (better to the right)"),
              ("total_rms_m", "rms error against the spectrum, m: left out waves too")]
    for axis, (metric, label) in zip(axes, panels):
        tried, named = [], {}
        for (state, knob, value), figures in run.trials.items():
            if state != GALE or "work_ms_per_s" not in figures:
                continue
            point = (max(figures[metric][0], 1e-7), figures["work_ms_per_s"][0])
            if knob == "named":
                named[value] = point
            if knob == "combination" or (knob == "named" and value in PRESETS):
                tried.append(point)
        axis.scatter(*zip(*tried), s=12, color="#b5b5b5", label="tried", zorder=2)
        axis.plot(*zip(*front(tried)), color=OURS, lw=1.2, label="best of them", zorder=2)
        for name, (error, work) in named.items():
            ours = name in PRESETS
            axis.scatter([error], [work], s=46, color=OURS if ours else THEIRS, marker="o" if ours else "D", zorder=3)
        axis.set_yscale("log")
        error_axis(axis, label)
        label_points(figure, axis, {n: (point, OURS if n in PRESETS else THEIRS) for n, point in named.items()})
        for limit, text in ((0.01, "1 cm"), (0.05, "5 cm"), (0.2, "20 cm")):
            axis.axvline(limit, color="#888888", lw=0.6, ls=":")
            axis.text(limit, 0.985, text, fontsize=7, color="#666666", ha="right", va="top", rotation=90,
                      transform=axis.get_xaxis_transform())
    axes[0].set_ylabel("work, ms of CPU a second of sea:\nmaps, stream, 10 000 answers")
    axes[0].legend(loc="upper left", bbox_to_anchor=(0.0, 0.9))
    figure.suptitle(f"A gale (Hs {run.figure(GALE, 'named', 'balanced', 'hs_m'):.1f} m) on {run.place['device']}")
    save(figure, path)


def sheet(run, knob, path, xlabel, cost, cost_label, title, state=GALE, only=None, xmin=None):
    """Error on the left, measured solid and expected dashed; cost on the right."""
    curves = {n: p for n, p in run.curves(state, knob).items() if only is None or n in only}
    if not curves:
        return
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.3))
    for colour, (name, points) in zip(COLOURS, curves.items()):
        get = lambda metric: [run.figure(state, knob, value, metric) for _, value in points]
        xs = [max(x, xmin) if xmin else x for x, _ in points]
        trials = [run.trials[(state, knob, value)]["rms_m"] for _, value in points]
        ys = [t[0] for t in trials]
        left.errorbar(xs, ys, yerr=[[max(t[0] - t[1], 0) for t in trials], [max(t[2] - t[0], 0) for t in trials]],
                      color=colour, marker="o", ms=3.5, lw=1.4, label=name, elinewidth=0.8)
        law = [(x, y) for x, y in zip(xs, get("predicted_rms_m")) if y and y > 1e-9]
        if law:
            left.plot(*zip(*law), color=colour, ls="--", lw=1)
        costs = [(x, y) for x, y in zip(xs, get(cost)) if y]
        if costs:
            right.plot(*zip(*costs), color=colour, marker="o", ms=3.5, lw=1.4, label=name)
    logarithmic = all(x > 0 for points in curves.values() for x, _ in points) or xmin
    for axis in (left, right):
        axis.set_xscale("log" if logarithmic else "linear")
        axis.set_yscale("log")
        axis.set_xlabel(xlabel)
    seen = [y for line in right.get_lines() for y in line.get_ydata()]
    if seen and max(seen) < 2 * min(seen):  # a knob that costs nothing: its noise is none of the picture
        right.set_yscale("linear")
        right.set_ylim(0, 1.5 * max(seen))
    left.set_ylabel("rms error of height, m")
    right.set_ylabel(cost_label)
    left.legend(fontsize=8)
    figure.suptitle(title + "  (solid: measured, dashed: expected)", fontsize=10)
    figure.tight_layout()
    save(figure, path)


def layout(run, path):
    """K3 and K4: what layouts of tiles hold."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.3))
    for metric, label, colour in (("missing_rms_m", "height, m", OURS), ("missing_slope_rms", "slope", THEIRS)):
        points = [(x, run.figure(GALE, "cascades", v, metric)) for x, v in run.curves(GALE, "cascades")["count"]]
        left.plot(*zip(*points), marker="o", ms=4, color=colour, label=label)
    left.set_yscale("log")
    left.set_xticks([1, 2, 3, 4])
    left.set_xlabel("cascades: 2111; 211; 317, 53; and 11 m")
    left.set_ylabel("rms of the waves left out")
    left.legend()
    for axis, knob, curve, label in ((middle, "cascades", "split", "second tile, m (first 2111 m, third 53 m)"),
                                     (right, "tile", "length", "longest tile, m")):
        points = [(x, run.figure(GALE, knob, v, "hs_scatter_pct")) for x, v in run.curves(GALE, knob)[curve]]
        axis.plot(*zip(*points), marker="o", ms=4, color=OURS)
        axis.set_xlabel(label)
        axis.set_ylabel("scatter of Hs over seeds, %")
        axis.set_ylim(0, 1.15 * max(y for _, y in points))
    figure.tight_layout()
    save(figure, path)


def together(run, path):
    """Grid, interval and codec together: whether their errors add up as the laws say, and whether a choice by hand
    beats a budget's."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
    for label, colour, by_hand in (("by a budget", OURS, False), ("by hand", THEIRS, True)):
        trials = [figures for (state, knob, value), figures in run.trials.items()
                  if (state, knob) == (GALE, "combination") and (" s@" in value) == by_hand]
        if not trials:
            continue
        errors = [figures["rms_m"][0] for figures in trials]
        expected = [figures["predicted_rms_m"][0] for figures in trials]
        left.scatter(expected, errors, s=16, color=colour, label=label)
        left.plot([min(expected), max(expected)], [min(expected), max(expected)], color="#888888", lw=0.8, ls="--")
        right.scatter(errors, [figures["work_ms_per_s"][0] for figures in trials], s=16, color=colour, label=label)
    for axis in (left, right):
        axis.set_xscale("log")
        axis.set_yscale("log")
    left.set_xlabel("expected rms, m: the laws' errors, added in the square")
    left.set_ylabel("measured rms, m")
    error_axis(right, "measured rms, m (better to the right)")
    right.set_ylabel("work, ms of CPU a second of sea")
    left.legend(fontsize=8)
    figure.tight_layout()
    save(figure, path)


def batches(run, path):
    """K12: an answer's time by how many are asked for at once; whiskers from the fastest round to the slowest."""
    curves = run.curves(GALE, "batch")
    if not curves:
        return
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.3))
    for axis, metric, scale, label in ((axes[0], "batch_ns", 1e-3, "us an answer"), (axes[1], "batch_ms", 1, "ms a batch")):
        for colour, (name, points) in zip(COLOURS, curves.items()):
            trials = [run.trials[(GALE, "batch", value)][metric] for _, value in points]
            below, above = [scale * (t[0] - t[1]) for t in trials], [scale * (t[2] - t[0]) for t in trials]
            axis.errorbar([x for x, _ in points], [scale * t[0] for t in trials], yerr=[below, above], color=colour,
                          marker="o", ms=3.5, lw=1.4, label=name, elinewidth=0.8)
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xlabel("points asked for at once")
        axis.set_ylabel(label)
    axes[1].legend(fontsize=8)
    figure.suptitle("K12: batches of questions (wall time; answers are the same)", fontsize=10)
    figure.tight_layout()
    save(figure, path)


def error_map(folder, path):
    file = folder / "error_map.csv"
    if not file.exists():
        return
    rows = list(csv.DictReader(file.open()))
    side = round(len(rows) ** 0.5)
    extent = [0, float(rows[-1]["x_m"]), 0, float(rows[-1]["y_m"])]
    grid = lambda name, scale: [[scale * float(r[name]) for r in rows[y * side:(y + 1) * side]] for y in range(side)]
    figure, axes = plt.subplots(2, 2, figsize=(9, 7.2))
    height, ours, theirs = grid("height_m", 1), grid("balanced_m", 1e3), grid("engine_m", 1e3)
    largest = lambda values: max(abs(v) for row in values for v in row)
    for axis, values, title, span, unit in (
            (axes[0][0], height, "height", largest(height), "m"),
            (axes[0][1], theirs, "error: same maps, linear filters, 16 bits", largest(theirs), "mm"),
            (axes[1][0], ours, "error: balanced, on a scale of its own", largest(ours), "mm"),
            (axes[1][1], ours, "error: balanced, on the scale above", largest(theirs), "mm")):
        image = axis.imshow(values, origin="lower", extent=extent, cmap="RdBu_r" if unit == "mm" else "viridis",
                            vmin=-span, vmax=span, interpolation="nearest")
        axis.set_title(title, fontsize=9)
        axis.grid(False)
        figure.colorbar(image, ax=axis, shrink=0.8, label=unit)
        axis.set_xlabel("m")
    figure.tight_layout()
    save(figure, path)


def draw_all(runs, folder, digest):
    save.digest = digest
    run = runs[0]
    name = lambda what: folder / f"accuracy_{what}.png"
    headline(run, name("headline"))
    for other in runs[1:]:
        headline(other, name(f"headline_{other.device}"))
    sheet(run, "cutoff", name("cutoff"), "cut-off, rad/m", "query_ns", "one thread's ns an exact answer",
          "K1: waves shorter than the cut-off are left out")
    sheet(run, "grid", name("grid"), "grid points a side (Seaway takes 64 for these waves)",
          "memory_mb", "MB of maps", "K2: between grid points")
    sheet(run, "phase", name("phase"), "time since the epoch, s", "query_ns", "ns an exact answer",
          "K7: phases", xmin=1)
    sheet(run, "interval", name("interval"), "keyframe interval, s", "keyframe_cpu_ms_per_s",
          "ms of CPU a second of sea", "K8: between keyframes")
    sheet(run, "codec", name("codec"), "what the codec may cost of the height, m", "bytes_per_s", "bytes a second",
          "K9: the codec's bound, with keyframes 0.25 s apart")
    sheet(run, "inverse", name("inverse"), "steps", "query_ns", "ns an answer", "K10: fixed-point steps",
          only=["fixed point"])
    sheet(run, "modes", name("modes"), "waves summed", "query_ns", "ns an answer", "K11: only the largest waves")
    sheet(run, "latency", name("latency"), "late by, s", "query_ns", "ns an answer", "K14: answers of a while ago")
    batches(run, name("batch"))
    layout(run, name("layout"))
    together(run, name("together"))
    error_map(run.path.parent, name("map"))

# SPDX-License-Identifier: Apache-2.0
"""The plots of docs/effects.md, from costs and counters as tools/effects_page.py reads them."""
from math import fsum

from plot_style import COLOURS, plt

EFFECTS = ["height", "choppy", "slopes", "gradient", "foam"]


def costs(all_costs, path):
    """Work of each cascade by effect, on top of the rest: maps below, stream above."""
    figure, axes = plt.subplots(1, len(all_costs), figsize=(11, 3.8))
    for axis, (name, cost) in zip(axes, all_costs.values()):
        cascades = cost.cascades()
        highest = 0
        for place, (part, shade) in enumerate((("maps", 1.0), ("stream", 0.45))):
            bottom = [0.0] * len(cascades)
            xs = [i + 0.4 * place - 0.2 for i in range(len(cascades))]
            marginal = {e: [cost.effect(e, c["cascade"])[f"more_{part}_ms"] for c in cascades] for e in EFFECTS}
            marginal["strains, shared"] = [c[f"{part}_ms"] - fsum(m[i] for m in marginal.values())
                                           for i, c in enumerate(cascades)]
            for colour, (effect, of_cascades) in zip([*COLOURS, "#d9b310"], marginal.items()):
                heights = [max(ms, 0) for ms in of_cascades]
                axis.bar(xs, heights, 0.36, bottom=bottom, color=colour, alpha=shade,
                         label=effect if part == "maps" else None)
                bottom = [b + h for b, h in zip(bottom, heights)]
            highest = max([highest, *bottom])
            for x, top in zip(xs, bottom):
                axis.annotate(part, (x, top), xytext=(0, 2), textcoords="offset points", ha="center", fontsize=7,
                              color="#555555")
        axis.set_xticks(range(len(cascades)), [c["cascade"].replace(" of ", "\nof ") for c in cascades])
        axis.set_title(name, fontsize=10)
        axis.set_xlim(-0.6, len(cascades) - 0.4)
        axis.grid(axis="x", visible=False)
        axis.set_ylim(0, 1.12 * highest)
    axes[0].set_ylabel("ms of CPU a second of sea,\non top of the other effects")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def demand(minute, path):
    """Transforms a second, stacked by effect and by cascade, above who is there."""
    figure, (upper, middle, lower) = plt.subplots(3, 1, figsize=(10, 7), sharex=True,
                                                  gridspec_kw={"height_ratios": [3, 3, 1.7]})
    edges = list(range(0, len(minute.times) - 1, 2))  # of bins of two samples, about a second
    times = [minute.times[i] for i in edges]

    def rates(wanted):
        return [sum(c[min(i + 2, len(c) - 1)] - c[i] for name, c in minute.counts.items() if wanted(name)) /
                (minute.times[min(i + 2, len(minute.times) - 1)] - minute.times[i]) for i in edges]

    everything = rates(lambda name: True)
    ceiling = 1.5 * sorted(everything)[len(everything) * 3 // 4]  # a start of foam goes far above
    cascades = sorted({name.split("@")[1] for name in minute.columns})
    upper.stackplot(times, [rates(lambda n, e=e: n.startswith(e)) for e in EFFECTS], labels=EFFECTS, colors=COLOURS,
                    alpha=0.85, linewidth=0, step="post")
    middle.stackplot(times, [rates(lambda n, c=c: n.endswith("@" + c)) for c in cascades],
                     labels=["longest tile", "middle tile", "shortest tile"], colors=COLOURS, alpha=0.85, linewidth=0, step="post")
    for axis, title in ((upper, "by effect"), (middle, "by cascade")):
        axis.set_ylabel(f"transforms a second,\n{title}")
        axis.legend(loc="upper left", fontsize=8)
        axis.set_ylim(0, ceiling)
        for i, rate in enumerate(everything):
            if rate > ceiling:
                foam = "foam starts: " if rate == max(everything) else ""
                axis.annotate(f"{foam}{rate:.0f}", (times[i] + 1, ceiling), xytext=(4, -12), textcoords="offset points",
                              fontsize=8)
    for row, (name, joins, leaves) in enumerate(minute.guests):
        lower.plot([joins, leaves], [-row, -row], color="#444444", lw=3, solid_capstyle="butt")
        lower.annotate(name, (joins, -row), xytext=(0, 4), textcoords="offset points", fontsize=7.5)
        for axis in (upper, middle, lower):
            for t in (joins, leaves):
                axis.axvline(t, color="#999999", lw=0.6, ls=":")
    lower.set_ylim(-len(minute.guests) + 0.5, 1)
    lower.set_yticks([])
    lower.grid(False)
    lower.set_xlim(minute.times[0], minute.times[-1])
    lower.set_xlabel("s since the server started")
    lower.set_ylabel("who is there")
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def draw_all(all_costs, minute, folder):
    costs(all_costs, folder / "effects_costs.png")
    demand(minute, folder / "effects_demand.png")

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/pictures/device.png of what `seaway-bench device` wrote: tools/device_pictures.py docs/device/*.csv
Each file is one device. Needs python3-matplotlib."""
import csv
import pathlib
import sys

from plot_style import COLOURS, plt

SIZES = [128, 256, 512]
# VkFFT 1.2.26 with other kernels for evolution and maps around it, eight maps of one tile, ms: of a prototype on lavapipe
# (Mesa 22.3.6), two cores of another machine (docs/performance/maps.md).
VKFFT_MS = {128: 1.90, 256: 6.8, 512: 20.3}
TILES = 3


class Device:
    def __init__(self, path):
        lines = path.read_text(encoding="utf-8").splitlines()
        self.name = path.stem
        self.rows = {(row["what"], row["size"], row["fields"]): row for row in csv.DictReader(lines[1:])}

    def value(self, what, size, fields, column):
        row = self.rows.get((what, str(size), fields))
        return float(row[column]) if row else None


def times(axis, devices):
    for device, colour in zip(devices, COLOURS):
        axis.plot(SIZES, [device.value("maps", n, "eight", "device_ms") for n in SIZES], "o-", color=colour,
                  label=device.name)
        axis.plot(SIZES, [device.value("fftw", n, "eight", "wall_ms") for n in SIZES], ":", marker="s", color=colour,
                  alpha=0.6)
    axis.plot([], [], "k:", marker="s", alpha=0.6, label="FFTW, transforms alone, in the same run")
    axis.plot(SIZES, [TILES * VKFFT_MS[n] for n in SIZES], "^--", color=COLOURS[4],
              label="VkFFT in a prototype: lavapipe, another machine,\nthree times one tile")
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    axis.set_xticks(SIZES, [str(n) for n in SIZES])
    axis.set_xlabel("points a side")
    axis.set_title("eight maps of three tiles, ms", fontsize=10)
    low, high = axis.get_ylim()
    axis.set_ylim(low, 50 * high)  # for the legend
    axis.legend(fontsize=7, loc="upper left")


def shares(axis, devices):
    bars = [(device, n, column) for column in ("memory_pct", "arithmetic_pct") for device in devices for n in SIZES]
    labels, place = [], 0
    for number, (device, n, column) in enumerate(bars):
        if number and number % len(SIZES) == 0:
            place += 1
        value = device.value("maps", n, "eight", column)
        axis.bar(place, value, 0.8, color=COLOURS[devices.index(device)],
                 label=device.name if column == "memory_pct" and n == SIZES[0] else None)
        axis.annotate(f"{value:.0f}", (place, value), xytext=(0, 2), textcoords="offset points", ha="center",
                      fontsize=7)
        labels.append((place, str(n)))
        place += 1
    axis.set_xticks([p for p, _ in labels], [t for _, t in labels], fontsize=7, rotation=90)
    half = len(devices) * (len(SIZES) + 1)
    for middle, text in ((half / 2 - 1, "of memory"), (half * 1.5 - 1, "of arithmetic")):
        axis.annotate(text, (middle, -0.16), xycoords=("data", "axes fraction"), ha="center", fontsize=9)
    axis.grid(axis="x", visible=False)
    axis.set_title("eight maps, % of what is there at best", fontsize=10)
    axis.legend(fontsize=8)


def beside(axis, devices, size):
    rows = [("maps", "all", "device_ms", "all maps"), ("foam", "a tick", "device_ms", "a tick of foam"),
            ("readback", "floats", "wall_ms", "readback, floats"), ("readback", "16 bits", "wall_ms", "readback, 16 bits")]
    width = 0.8 / len(devices)
    for i, (device, colour) in enumerate(zip(devices, COLOURS)):
        values = [device.value(what, size, fields, column) for what, fields, column, _ in rows]
        places = [len(rows) - 1 - row + 0.4 - width * (i + 0.5) for row in range(len(rows))]
        axis.barh(places, [v or 0 for v in values], 0.9 * width, color=colour, label=device.name)
        for place, value in zip(places, values):
            axis.annotate("none" if value is None else f"{value:.2g}", (value or 0, place), xytext=(3, 0),
                          textcoords="offset points", va="center", fontsize=7)
    axis.set_yticks(range(len(rows)), [label for *_, label in reversed(rows)])
    axis.grid(axis="y", visible=False)
    axis.margins(x=0.15)
    axis.set_title(f"a keyframe of three tiles of {size}, ms", fontsize=10)
    axis.legend(fontsize=8)


def main(paths):
    if not paths:
        print(__doc__, file=sys.stderr)
        return 2
    devices = [Device(pathlib.Path(path)) for path in sorted(paths, reverse=True)]
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.2))
    times(axes[0], devices)
    shares(axes[1], devices)
    beside(axes[2], devices, 256)
    figure.tight_layout()
    figure.savefig(pathlib.Path(__file__).parent.parent / "docs/pictures/device.png")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

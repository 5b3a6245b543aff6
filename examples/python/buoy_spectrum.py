#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What wave buoys would measure: records of half an hour, their spectrum by Welch, and the spectrum that was asked for.

    buoy_spectrum.py ws://127.0.0.1:9430 scenes/north_sea_gale.toml [buoy.csv [spectrum.png]]

25 of them, a kilometre apart, for half an hour at 4 Hz, out of the waves themselves, which are sent once. Each stays
where it is: crests that are sharpened pass it, which adds a little far below the peak of what was asked for.
What was asked for is what seaway-inspect says of the scene.
Needs python3-numpy and, for the plot, python3-matplotlib.
"""
import io
import subprocess
import sys

import numpy

import seaway

RATE_HZ = 4.0
RECORD_S = 1800
SEGMENT = 1024  # samples: 256 s, lines 1/256 Hz apart
BUOYS = 5       # a side


def records(sea):
    """Heights above mean water, m: [buoy, sample]."""
    begin_us = sea.now_us()
    times_us = begin_us + numpy.arange(int(RECORD_S * RATE_HZ)) * int(1e6 / RATE_HZ)
    # Points of one time stand together: their waves are turned to that time once.
    x_m, y_m = numpy.meshgrid(numpy.arange(BUOYS) * 1013.0, numpy.arange(BUOYS) * 967.0)
    asked = seaway.points(x_m.ravel(), y_m.ravel(), times_us[:, None])
    return sea.sample(asked)["height_m"].T


def welch(heights_m):
    """One-sided S(f) in m2/Hz of all records: Hann, segments that overlap by half, each without its mean."""
    window = numpy.hanning(SEGMENT)
    starts = range(0, heights_m.shape[1] - SEGMENT + 1, SEGMENT // 2)
    segments = numpy.concatenate([heights_m[:, start:start + SEGMENT] for start in starts])
    segments = segments - segments.mean(axis=1, keepdims=True)
    power = numpy.abs(numpy.fft.rfft(segments * window)) ** 2
    density = 2 * power.mean(axis=0) / (RATE_HZ * (window ** 2).sum())
    return numpy.fft.rfftfreq(SEGMENT, 1 / RATE_HZ), density


def requested(scene, frequencies_hz):
    """S(f) = 2 pi S(w) of the scene, by seaway-inspect."""
    words = ",".join(f"{2 * numpy.pi * f:.9g}" for f in frequencies_hz)
    table = subprocess.run(["seaway-inspect", scene, "--spectrum", words], check=True, capture_output=True,
                           text=True).stdout
    values = numpy.genfromtxt(io.StringIO(table), delimiter=",", names=True)
    return 2 * numpy.pi * values["s_m2s"]


def height_of(frequencies_hz, density):
    return 4 * numpy.sqrt(((density[1:] + density[:-1]) / 2 * numpy.diff(frequencies_hz)).sum())


def draw(path, frequencies_hz, measured, wanted):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    axes.semilogy(frequencies_hz, wanted, color="#c8601a", label="asked for")
    axes.semilogy(frequencies_hz, measured, color="#1f5fa8", label=f"{BUOYS * BUOYS} buoys, half an hour")
    axes.set(xlabel="frequency, Hz", ylabel="S, m2/Hz", xlim=(0, 0.5), ylim=(wanted.max() * 1e-4, wanted.max() * 3))
    axes.grid(color="#e2e2e2")
    axes.legend(frameon=False)
    figure.savefig(path, bbox_inches="tight")


def main(url, scene, table="buoy.csv", picture="spectrum.png"):
    with seaway.Sea(url) as sea:
        sea.subscribe(seaway.SPECTRUM)
        heights_m = records(sea)
    times_s = numpy.arange(heights_m.shape[1]) / RATE_HZ
    numpy.savetxt(table, numpy.column_stack([times_s, heights_m.T]), fmt="%.4f", delimiter=",",
                  header="time_s," + ",".join(f"buoy_{i}_m" for i in range(len(heights_m))), comments="")
    frequencies_hz, measured = welch(heights_m)
    shown = (frequencies_hz > 0.03) & (frequencies_hz < 0.5)
    frequencies_hz, measured = frequencies_hz[shown], measured[shown]
    wanted = requested(scene, frequencies_hz)
    print(f"Hs {height_of(frequencies_hz, measured):.2f} m measured, {height_of(frequencies_hz, wanted):.2f} m asked "
          f"for; peak {frequencies_hz[measured.argmax()]:.3f} Hz and {frequencies_hz[wanted.argmax()]:.3f} Hz")
    draw(picture, frequencies_hz, measured, wanted)


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except seaway.SeaError as error:
        sys.exit(f"buoy_spectrum: {error}")

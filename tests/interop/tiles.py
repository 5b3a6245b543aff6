# SPDX-License-Identifier: Apache-2.0
"""Tiles to maps: codec version 1 (docs/protocol.md, "Tiles")."""
import math
import struct
import zlib

import numpy as np
import zstandard

CONSTANT, QUANTISED, LOSSLESS, DIFFERENCE = 0, 1, 2, 3
FINE_STEPS = 8  # in a step of a difference


def codes_of(plain, planes, count):
    """One whole number a sample: byte planes, or two a byte."""
    if planes == 0:
        pairs = np.frombuffer(plain, np.uint8, (count + 1) // 2).astype(np.uint32)
        return np.stack([pairs & 15, pairs >> 4], axis=1).ravel()[:count]
    codes = np.zeros(count, np.uint32)
    for plane in range(planes):
        part = np.frombuffer(plain, np.uint8, count, plane * count).astype(np.uint32)
        codes |= part << np.uint32(8 * plane)
    return codes


def decode_difference(payload, step, residual, expected):
    """The samples that are so many steps from what is expected; rounded to the lattice, halves to the even point."""
    lattice = np.rint(expected.astype(np.float64) / step) + FINE_STEPS * residual.view(np.int32).astype(np.float64)
    samples = (lattice * step).astype(np.float32)
    if struct.unpack_from("<I", payload, 16)[0] != zlib.crc32(samples.tobytes()):
        raise ValueError("something else was expected")
    return samples


def decode(payload, expected=None):
    """The samples of one part, [y][x] of float32. `expected`, likewise: of a difference, what it is to."""
    version, mode, width, height, planes, zero, parameter, checksum = struct.unpack_from("<BBHHBBfI", payload)
    if version != 1 or zero != 0 or zlib.crc32(payload[16:], zlib.crc32(payload[:12])) != checksum:
        raise ValueError("not a tile of codec version 1, or damaged")
    if mode == CONSTANT:
        return np.full((height, width), parameter, np.float32)
    count = width * height
    frame = payload[20:] if mode == DIFFERENCE else payload[16:]
    size = planes * count if planes else (count + 1) // 2
    codes = codes_of(zstandard.ZstdDecompressor().decompress(frame, max_output_size=size), planes, count)
    residual = (codes >> np.uint32(1)) ^ (np.uint32(0) - (codes & np.uint32(1)))
    if mode == DIFFERENCE:
        return decode_difference(payload, float(parameter), residual.reshape(height, width), expected)
    # u(x, y) = r + u(x-1, y) + u(x, y-1) - u(x-1, y-1) is the sum of all r to the lower left.
    u = residual.reshape(height, width).cumsum(axis=1, dtype=np.uint32).cumsum(axis=0, dtype=np.uint32)
    if mode == QUANTISED:
        return (u.view(np.int32).astype(np.float64) * float(parameter)).astype(np.float32)
    if mode == LOSSLESS:
        flipped = np.where(u >> np.uint32(31), u ^ np.uint32(0x7FFFFFFF), u)
        return flipped.astype(np.uint32).view(np.float32)
    raise ValueError(f"mode {mode} is not known")


def disc(size):
    """The waves that a compact grid holds, [ny][nx] in the order of a transform."""
    n = np.fft.fftfreq(size, 1 / size).round()
    return 4 * (n[:, None] ** 2 + n[None, :] ** 2) < size * size


def enlarged(samples, size):
    """A compact map on its cascade's own grid (docs/protocol.md, "Compact maps")."""
    small = samples.shape[0]
    waves = np.fft.fft2(samples.astype(np.float64)) * disc(small)
    n = np.fft.fftfreq(small, 1 / small).round().astype(int)
    placed = np.zeros((size, size), complex)
    placed[np.ix_(n % size, n % size)] = waves
    return (np.fft.ifft2(placed).real * (size / small) ** 2).astype(np.float32)


def followers(samples, size, length_m, depth_m):
    """The two displacements that follow from a compact map of heights, or their rates from its rate."""
    small = samples.shape[0]
    n = np.fft.fftfreq(small, 1 / small).round()
    index = np.hypot(n[:, None], n[None, :])
    index[0, 0] = 1.0
    kd = np.maximum(2 * np.pi * index / length_m * (depth_m or np.inf), 0.05)
    moved = 1j * np.fft.fft2(samples.astype(np.float64)) / np.tanh(kd) / index
    return [enlarged(np.fft.ifft2(moved * axis * disc(small)).real, size) for axis in (n[None, :], n[:, None])]


class Keyframe:
    """Maps of one cascade at one time, by field number, and the bound of each; `size`: of the cascade's own grid."""

    def __init__(self, size, length_m, depth_m):
        self.length_m, self.depth_m = length_m, depth_m
        self.gains = {}  # of the variance of what follows from another map
        self.maps, self.errors, self.missing, self.size = {}, {}, {}, size
        self.compact_size = None  # of the grid that linear maps came on, if it was a smaller one
        self.coarser = {"interval_us": 0}  # what they miss beside what the sea says

    def add(self, tile):
        """True when all parts of this field are there."""
        field = tile["field"]
        self.coarser = tile["coarser"] or self.coarser
        if field not in self.maps:
            self.maps[field] = np.zeros((tile["size"], tile["size"]), np.float32)
            self.errors[field] = 0.0
            self.missing[field] = set(range(tile["parts"]))
        if tile["part"] not in self.missing[field]:
            return not self.missing[field]  # again, by the stream; this one may be on its own grid already
        x0, y0 = tile["x0"], tile["y0"]
        self.maps[field][y0:y0 + tile["height"], x0:x0 + tile["width"]] = decode(tile["payload"])
        self.errors[field] = max(self.errors[field], tile["error"])
        self.missing[field].discard(tile["part"])
        if not self.missing[field] and self.maps[field].shape[0] < self.size:
            self.compact_size = self.maps[field].shape[0]
            follows = [f for f in range(32) if tile["follows"] >> f & 1]
            for f, map_of in zip(follows, followers(self.maps[field], self.size, self.length_m, self.depth_m)):
                self.maps[f], self.missing[f], self.errors[f] = map_of, set(), self.errors[field]
                self.gains[f] = self.gain()
            self.maps[field] = enlarged(self.maps[field], self.size)
        return not self.missing[field]

    def gain(self):
        """Of displacements that follow: the mean of coth^2(k d) / 2 over the waves that a compact grid holds."""
        n = np.fft.fftfreq(self.compact_size, 1 / self.compact_size).round()
        index = np.hypot(n[:, None], n[None, :])[disc(self.compact_size)]
        kd = np.maximum(2 * np.pi * index[index > 0] / self.length_m * (self.depth_m or np.inf), 0.05)
        return (1 / np.tanh(kd) ** 2).mean() / 2

    def coded_rms(self, field):
        """Standard deviation of what coding made of a map."""
        share = disc(self.compact_size).mean() if self.compact_size else 1.0
        return self.errors.get(field, 0.0) * math.sqrt(share * self.gains.get(field, 1.0) / 3)

    def holds(self, fields):
        return all(field in self.maps and not self.missing[field] for field in fields)

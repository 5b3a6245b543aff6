# SPDX-License-Identifier: Apache-2.0
"""A sea from its waves (docs/protocol.md, "The spectrum")."""
import struct
import zlib

import numpy as np
import zstandard

SIDE = 8  # waves of a block along each axis


def blocks(payload):
    """(cascade, shift, bx, by, codes[j][i][real, imaginary]) of a chunk."""
    version, planes, count, checksum = struct.unpack_from("<BBHI", payload)
    if version != 1 or zlib.crc32(payload[8:], zlib.crc32(payload[:4])) != checksum:
        raise ValueError("not a spectrum of codec version 1, or damaged")
    values = count * 2 * SIDE * SIDE
    plain = zstandard.ZstdDecompressor().decompress(payload[8:], max_output_size=4 * count + planes * values)
    codes = np.zeros(values, np.uint32)
    for plane in range(planes):
        part = np.frombuffer(plain, np.uint8, values, 4 * count + plane * values).astype(np.uint32)
        codes |= part << np.uint32(8 * plane)
    signed = ((codes >> np.uint32(1)) ^ (np.uint32(0) - (codes & np.uint32(1)))).view(np.int32)
    signed = signed.reshape(count, SIDE, SIDE, 2).astype(np.float64)
    for number in range(count):
        cascade, flags, bx, by = struct.unpack_from("<BBbb", plain, 4 * number)
        yield cascade, flags & 15, bx, by, signed[number]


class Spectrum:
    """Waves as they come; `left_m` is what is still missed of a height, `left_displacement_m` of a displacement."""

    def __init__(self, state, head):
        self.state, self.head = state, head
        self.next = 0
        self.left_m = self.left_displacement_m = None
        self.waves = [{} for _ in state["cascades"]]  # h0 by (nx, ny)

    def add(self, chunk):
        if chunk["chunk"] != self.next:
            raise ValueError("a chunk is missing")
        self.next += 1
        self.left_m, self.left_displacement_m = chunk["left_m"], chunk["left_displacement_m"]
        for cascade, shift, bx, by, codes in blocks(chunk["payload"]):
            step_k = 2 * np.pi / self.state["cascades"][cascade]["length_m"]
            for j, i in zip(*np.nonzero(codes.any(axis=2))):
                nx, ny = SIDE * bx + int(i), SIDE * by + int(j)
                k = step_k * np.hypot(nx, ny)
                step = self.head["step_m"] * (2.0 ** shift if shift else 1 / np.hypot(1, k * self.head["step_length_m"]))
                held = self.waves[cascade].get((nx, ny), 0)
                self.waves[cascade][nx, ny] = held + step * complex(*codes[j, i])

    @property
    def whole(self):
        return self.next == self.head["chunks"]

    def at(self, x_m, y_m, time_us):
        """eta, D_x, D_y at an undisplaced place: eta = 2 Re sum h0 exp(i (k.X - w t))."""
        total = np.zeros(3)
        for cascade, waves in zip(self.state["cascades"], self.waves):
            if not waves:
                continue
            n = np.array(list(waves.keys()), float)
            h0 = np.array(list(waves.values()))
            step_k = 2 * np.pi / cascade["length_m"]
            k = step_k * np.hypot(n[:, 0], n[:, 1])
            deep = self.head["depth_m"]
            omega = np.sqrt((self.head["gravity_mps2"] * k + self.head["surface_tension_m3ps2"] * k ** 3) * np.tanh(k * deep))
            if self.head["loop_period_us"]:
                period = self.head["loop_period_us"]
                time_us = time_us % period
                omega = np.maximum(np.round(omega * period * 1e-6 / (2 * np.pi)), 1) * 2 * np.pi / (period * 1e-6)
            place = (n[:, 0] * (x_m % cascade["length_m"]) + n[:, 1] * (y_m % cascade["length_m"])) * step_k
            moving = 2 * h0 * np.exp(1j * (place - omega * (time_us * 1e-6)))
            aspect = 1 / np.tanh(np.maximum(k * deep, 0.05))
            total[0] += moving.real.sum()
            for axis in range(2):
                total[1 + axis] += (1j * n[:, axis] * step_k / k * aspect * moving).real.sum()
        return total

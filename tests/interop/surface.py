# SPDX-License-Identifier: Apache-2.0
"""Heights from keyframes (docs/protocol.md, "Heights from tiles" and "Foam")."""
import math

import numpy as np

HEIGHT, DISPLACEMENT_X, DISPLACEMENT_Y = 0, 1, 2
RATE_OF = {HEIGHT: 3, DISPLACEMENT_X: 4, DISPLACEMENT_Y: 5}
FOAM = 12


def coefficients(samples):
    """Of the bicubic B-spline through periodic samples."""
    size = samples.shape[0]
    response = (2 + np.cos(2 * np.pi * np.fft.fftfreq(size))) / 3
    return np.fft.ifft2(np.fft.fft2(samples.astype(np.float64)) / np.outer(response, response)).real


def weights(t):
    """Of the four coefficients around a place, and their derivatives."""
    w = [(1 - t) ** 3 / 6, (3 * t ** 3 - 6 * t ** 2 + 4) / 6, (-3 * t ** 3 + 3 * t ** 2 + 3 * t + 1) / 6, t ** 3 / 6]
    d = [-(1 - t) ** 2 / 2, (3 * t ** 2 - 4 * t) / 2, (-3 * t ** 2 + 2 * t + 1) / 2, t ** 2 / 2]
    return np.array(w), np.array(d)


class Spline:
    """A keyframe ready for sampling: fields 0 to 5, those that it lacks are zero."""

    def __init__(self, keyframe, length_m):
        flat = np.zeros((keyframe.size, keyframe.size), np.float32)
        self.size, self.length_m = keyframe.size, length_m
        self.c = np.stack([coefficients(keyframe.maps.get(field, flat)) for field in range(6)])

    def sample(self, x_m, y_m):
        """(values, derivatives along X, derivatives along Y) of the six fields."""
        def place(at_m):
            u = (at_m % self.length_m) / self.length_m * self.size
            i = math.floor(u)
            return (np.arange(i - 1, i + 3) % self.size, *weights(u - i))
        columns, wx, dx = place(x_m)
        rows, wy, dy = place(y_m)
        block = self.c[:, rows[:, None], columns[None, :]]
        per_m = self.size / self.length_m
        return (np.einsum("fyx,y,x->f", block, wy, wx), np.einsum("fyx,y,x->f", block, wy, dx) * per_m,
                np.einsum("fyx,y,x->f", block, dy, wx) * per_m)


def hermite(t_us, t0_us, t1_us):
    """Weights of (p0, v0, p1, v1) for the value and for its rate."""
    span = (t1_us - t0_us) * 1e-6
    s = (t_us - t0_us) * 1e-6 / span
    r = 1 - s
    return ((r * r * (1 + 2 * s), s * r * r * span, s * s * (1 + 2 * r), -s * s * r * span),
            (-6 * s * r / span, r * (1 - 3 * s), 6 * s * r / span, s * (1 - 3 * r)))


def glided(state, name, time_us):
    """What a value of a sea state is at a time: where the sea glides, on the way from what it began with."""
    glide = state.get("glide")
    if not glide:
        return state[name]
    x = np.clip((time_us - state["start_time_us"]) / (glide["end_us"] - state["start_time_us"]), 0, 1)
    return glide[name] + x**3 * (10 - 15 * x + 6 * x * x) * (state[name] - glide[name])


class Surface:
    """The sea at one time; pairs are ((t0_us, keyframe), (t1_us, keyframe)), one a cascade."""

    def __init__(self, state, pairs, time_us):
        self.state, self.pairs, self.time_us = state, pairs, time_us
        self.choppiness = np.array([glided(state, name, time_us) for name in ("choppiness_x", "choppiness_y")])
        self.parts = []
        for cascade, ((t0, k0), (t1, k1)) in zip(state["cascades"], pairs):
            length_m = cascade["length_m"]
            self.parts.append((Spline(k0, length_m), Spline(k1, length_m), *hermite(time_us, t0, t1)))

    def at(self, x_m, y_m):
        """(value, rate, d/dX, d/dY) of eta, D_x, D_y at the undisplaced place, all cascades summed."""
        out = np.zeros((4, 3))
        for before, after, value_w, rate_w in self.parts:
            a, b = before.sample(x_m, y_m), after.sample(x_m, y_m)
            for row, (which, w) in enumerate(((0, value_w), (0, rate_w), (1, value_w), (2, value_w))):
                out[row] += w[0] * a[which][:3] + w[1] * a[which][3:] + w[2] * b[which][:3] + w[3] * b[which][3:]
        return out

    def answer(self, x_m, y_m):
        """Height, normal, velocity, bound on the height, and whether the surface folds here."""
        lx, ly = self.choppiness
        target = np.array([x_m, y_m])
        longest = self.state["displacement_reach_m"]
        place = target.copy()
        sea = self.at(*place)
        for _ in range(30):
            residual = place + self.choppiness * sea[0, 1:] - target
            length = np.hypot(*residual)
            if length < 0.02 * self.state["height_error_m"]:
                break
            gradient = np.array([[1 + lx * sea[2, 1], lx * sea[3, 1]], [ly * sea[2, 2], 1 + ly * sea[3, 2]]])
            step = -np.linalg.solve(gradient, residual)
            step *= min(1.0, longest / max(np.hypot(*step), 1e-12))
            for _ in range(10):
                following = self.at(*(place + step))
                if np.hypot(*(place + step + self.choppiness * following[0, 1:] - target)) < length:
                    break
                step /= 2
            place, sea = place + step, following
        eta_x, xx, _ = sea[2]
        eta_y, xy, yy = sea[3]
        jacobian = (1 + lx * xx) * (1 + ly * yy) - lx * ly * xy * xy
        normal = np.array([ly * xy * eta_y - (1 + ly * yy) * eta_x, lx * xy * eta_x - (1 + lx * xx) * eta_y, jacobian])
        normal *= np.copysign(1, jacobian) / np.linalg.norm(normal)
        slope = min(np.hypot(normal[0], normal[1]) / max(normal[2], 1e-12), 10)
        return {"height_m": sea[0, 0], "normal": normal, "velocity_mps": np.array([sea[1, 1], sea[1, 2], sea[1, 0]]),
                "error_m": self.bound(slope, place, length), "folded": jacobian <= 0, "place": place}

    def bound(self, slope, place, residual):
        lx, ly = self.choppiness
        state, variance, precision = self.state, 0.0, 1
        for loss, cascade, ((t0, k0), (t1, k1)) in zip(state["losses"], state["cascades"], self.pairs):
            share = (self.time_us - t0) / (t1 - t0) if t1 > t0 else 0.0
            weights = hermite(self.time_us, t0, t1)[0]
            cells = [place[axis] * cascade["size"] / cascade["length_m"] for axis in (0, 1)]
            compact = bool(k0.compact_size or k1.compact_size)
            precision = 3 if compact else precision
            east, north = (between(cell - math.floor(cell)) for cell in cells)

            def rms(*fields):
                return max(k.coded_rms(f) for k in (k0, k1) for f in fields)

            far = t1 - t0 > cascade["interval_us"]

            def missed(prefix, *fields):
                coarser = [k.coarser for k in (k0, k1) if k.coarser["interval_us"]]
                cut = max((c[prefix + "cut_m"] for c in coarser), default=0)
                time = max([loss[prefix + "time_m"]] + [c[prefix + "time_m"] for c in coarser if far])
                return (cut ** 2 + (between(share) * time) ** 2 + east * loss[prefix + "east_m"] ** 2
                        + north * loss[prefix + "north_m"] ** 2
                        + (1 if compact else (1 - east / 5) * (1 - north / 5))
                        * ((weights[0] ** 2 + weights[2] ** 2) * rms(*fields) ** 2
                           + (weights[1] ** 2 + weights[3] ** 2) * rms(*(RATE_OF[f] for f in fields)) ** 2))
            variance += missed("", HEIGHT)
            variance += (slope * max(lx, ly)) ** 2 * missed("displacement_", DISPLACEMENT_X, DISPLACEMENT_Y)
        return (5 * math.sqrt(variance) + precision * state["single_precision_m"]
                + slope * max(lx, ly) * precision * state["single_precision_displacement_m"] + slope * residual)


def between(s):
    """0 at the ends of a cell, 1 in its middle."""
    return 16 * s * s * (1 - s) * (1 - s)


def foam(state, pairs, time_us, place):
    """Share of white water at an undisplaced place."""
    product = 1.0
    for cascade, ((t0, k0), (t1, k1)) in zip(state["cascades"], pairs):
        def linear(map_of):
            size = map_of.shape[0]
            u = (place % cascade["length_m"]) / cascade["length_m"] * size
            i = np.floor(u).astype(int)
            f = u - i
            block = map_of[np.ix_((i[1] + np.arange(2)) % size, (i[0] + np.arange(2)) % size)]
            return np.array([1 - f[1], f[1]]) @ block @ np.array([1 - f[0], f[0]])
        s = (time_us - t0) / (t1 - t0)
        ratio = (1 - s) * linear(k0.maps[FOAM]) + s * linear(k1.maps[FOAM])
        product *= (1 + ratio) / 2
    return min(max(glided(state, "foam_mean", time_us) * (2 * product - 1), 0.0), 1.0)

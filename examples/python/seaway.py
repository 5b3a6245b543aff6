# SPDX-License-Identifier: Apache-2.0
"""Seaway's C interface in Python: ctypes and numpy alone. What things mean, and their units, stands in seaway/seaway.h.

    import seaway
    with seaway.Sea("ws://127.0.0.1:9430") as sea:
        sea.subscribe()
        points = seaway.points([0, 10, 20], 0, sea.now_us())
        print(sea.sample(points)["height_m"])
"""
import ctypes
import os

import numpy

POINT = numpy.dtype([("x_m", "f8"), ("y_m", "f8"), ("time_us", "i8")], align=True)
ANSWER = numpy.dtype([("height_m", "f8"), ("normal", "f8", 3), ("velocity_mps", "f8", 3), ("error_m", "f8"),
                      ("flags", "u4"), ("reserved", "u4")], align=True)
TERMS = numpy.dtype([("answer", ANSWER)] + [(term, "f8") for term in (
    "codec_m", "time_m", "space_m", "inverse_m", "rounding_m", "clock_m", "stale_m")], align=True)
ABI_VERSION = 3
TILES, SPECTRUM = 0, 1
STATED_TIMES, TIMES_OF_NOW = 0, 1


class Subscription(ctypes.Structure):
    _fields_ = [("error_m", ctypes.c_double), ("credit", ctypes.c_uint32), ("rung", ctypes.c_uint32),
                ("timeout_s", ctypes.c_double), ("rate_hz_max", ctypes.c_double), ("size_max", ctypes.c_uint32),
                ("reserved", ctypes.c_uint32)]


class Sampling(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("parts", ctypes.c_uint32), ("probe", ctypes.c_void_p),
                ("times", ctypes.c_uint32), ("from_", ctypes.c_uint32),
                ("looking", ctypes.c_void_p)]


class SeaAt(ctypes.Structure):
    _fields_ = [("start_time_us", ctypes.c_int64), ("hs_m", ctypes.c_double), ("tp_s", ctypes.c_double),
                ("tz_s", ctypes.c_double), ("mean_from_deg", ctypes.c_double), ("height_error_m", ctypes.c_double),
                ("epoch", ctypes.c_uint32), ("cascades", ctypes.c_uint32)]


class SeaError(RuntimeError):
    pass


def _load():
    library = ctypes.CDLL(os.environ.get("SEAWAY_LIBRARY", "libseaway.so.0"))
    if library.seaway_abi_version() != ABI_VERSION:
        raise SeaError(f"this file is for version {ABI_VERSION} of the interface")
    client, count, seconds = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double
    library.seaway_last_error.restype = ctypes.c_char_p
    library.seaway_connect.argtypes = [ctypes.c_char_p, ctypes.c_void_p, ctypes.POINTER(client)]
    library.seaway_disconnect.argtypes = [client]
    library.seaway_now_us.argtypes = [client]
    library.seaway_now_us.restype = ctypes.c_int64
    library.seaway_sea_at.argtypes = [client, ctypes.c_int64, ctypes.POINTER(SeaAt)]
    library.seaway_subscribe.argtypes = [client, ctypes.POINTER(Subscription)]
    library.seaway_sample.argtypes = [client, ctypes.c_void_p, count, ctypes.c_void_p]
    library.seaway_sample_terms.argtypes = [client, ctypes.POINTER(Sampling), ctypes.c_void_p, count, ctypes.c_void_p,
                                            count]
    library.seaway_query.argtypes = [client, ctypes.c_void_p, count, ctypes.c_int, seconds, ctypes.c_void_p]
    return library


_library = _load()


def _require(code):
    if code != 0:
        raise SeaError(_library.seaway_last_error().decode())


def points(x_m, y_m, time_us):
    """Points for sample() and query(); whatever numpy broadcasts to one shape."""
    x_m, y_m, time_us = numpy.broadcast_arrays(x_m, y_m, time_us)
    made = numpy.empty(x_m.shape, POINT)
    made["x_m"], made["y_m"], made["time_us"] = x_m, y_m, time_us
    return made


class Sea:
    """A connection. Used as a context it ends with its block."""

    def __init__(self, url):
        self._client = ctypes.c_void_p()
        _require(_library.seaway_connect(url.encode(), None, ctypes.byref(self._client)))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        _library.seaway_disconnect(self._client)
        self._client = ctypes.c_void_p()

    def now_us(self):
        return _library.seaway_now_us(self._client)

    def at(self, time_us):
        sea = SeaAt()
        _require(_library.seaway_sea_at(self._client, time_us, ctypes.byref(sea)))
        return sea

    def subscribe(self, rung=TILES, **wishes):
        _require(_library.seaway_subscribe(self._client, ctypes.byref(Subscription(rung=rung, **wishes))))

    def sample(self, asked):
        """Answers of the shape of the points, from what this process holds."""
        return self._answers(asked, lambda at, count, out: _library.seaway_sample(self._client, at, count, out))

    def terms(self, asked, times=STATED_TIMES):
        """Likewise, with what each error is made of; TIMES_OF_NOW: times of now_us(), with the clock's part."""
        how = Sampling(size=ctypes.sizeof(Sampling), times=times)
        return self._answers(asked, lambda at, count, out: _library.seaway_sample_terms(
            self._client, ctypes.byref(how), at, count, out, TERMS.itemsize), TERMS)

    def query(self, asked, exact=False, timeout_s=0):
        """Likewise, by the server."""
        return self._answers(asked, lambda at, count, out: _library.seaway_query(
            self._client, at, count, int(exact), timeout_s, out))

    @staticmethod
    def _answers(asked, call, kind=ANSWER):
        asked = numpy.require(asked, POINT, "C")  # ascontiguousarray makes a row of one point
        answers = numpy.empty(asked.shape, kind)
        _require(call(asked.ctypes.data, asked.size, answers.ctypes.data))
        return answers

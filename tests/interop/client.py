# SPDX-License-Identifier: Apache-2.0
"""A session with a Seaway server, written from docs/protocol.md alone."""
import pathlib
import select

import spectrum
import surface
import tiles
import websocket
from flat import Schema

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SCHEMA = Schema((ROOT / "protocol" / "seaway.fbs").read_text())
SURFACE_FIELDS = 63  # fields 0 to 5


class Refused(Exception):
    def __init__(self, message):
        super().__init__(message["message"])
        self.code = message["code"]


class Keyframe:
    """Its tiles as they come, decoded when nothing else has come, or when somebody looks at them. Who decodes before he acknowledges
    falls behind a stream where the machine is slow: he is sent the newest, and never holds two keyframes that follow each other."""

    def __init__(self, size, length_m, depth_m):
        self.whole_size = size
        self.coarser = {"interval_us": 0}
        self.missing_parts = {}  # by field
        self.to_decode = []
        self.decoded = tiles.Keyframe(size, length_m, depth_m)

    def add(self, tile):
        self.coarser = tile["coarser"] or self.coarser
        self.to_decode.append(tile)
        missing = self.missing_parts.setdefault(tile["field"], set(range(tile["parts"])))
        missing.discard(tile["part"])
        if not missing and tile["size"] < self.whole_size:
            self.missing_parts.update({f: set() for f in range(32) if tile["follows"] >> f & 1})

    def holds(self, fields):
        return all(field in self.missing_parts and not self.missing_parts[field] for field in fields)

    def decode(self):
        arrived, self.to_decode = self.to_decode, []
        for tile in arrived:
            self.decoded.add(tile)

    def __getattr__(self, name):
        """Whatever the decoded one has."""
        self.decode()
        return getattr(self.decoded, name)


class Session:
    def __init__(self, host, port, token="", compact=False):
        self.compact = compact  # takes linear maps on smaller grids
        self.socket = websocket.WebSocket(host, port, "/v1/stream", "seaway.v1")
        self.states = {}  # by epoch
        self.keyframes = {}  # by (epoch, cascade, time_us)
        self.granted = None
        self.complete = []  # keyframes that are, and were not acknowledged
        self.arrived = []  # keyframes with tiles that are not decoded
        self.spectra = {}  # by epoch
        self.last_id = 0
        self.send("Hello", versions=[1], client="interop", token=token)
        self.welcome = self.wait_for("Welcome")
        while not self.states:
            self.receive()

    def send(self, kind, **values):
        self.socket.send(SCHEMA.write_message(kind, **values))

    def receive(self):
        """The next message; what belongs to the session has been taken from it."""
        while self.arrived and not self.socket.received and not select.select([self.socket.socket], [], [], 0)[0]:
            self.arrived.pop(0).decode()
        message = SCHEMA.read_message(self.socket.receive())
        kind = message["kind"]
        if kind == "SeaState":
            self.states[message["epoch"]] = message
        elif kind == "Subscribed":
            self.granted = message
            self.acknowledge(1)
        elif kind == "Spectrum":
            self.spectra[message["epoch"]] = spectrum.Spectrum(self.states[message["epoch"]], message)
        elif kind == "SpectrumChunk":
            self.spectra[message["epoch"]].add(message)
        elif kind == "Tile":
            self.take(message)
        elif kind == "GoAway":
            raise websocket.Closed(message["code"], message["message"])
        return message

    def take(self, tile):
        key = (tile["epoch"], tile["cascade"], tile["time_us"])
        state = self.states[tile["epoch"]]
        cascade = state["cascades"][tile["cascade"]]
        keyframe = self.keyframes.setdefault(
            key, Keyframe(cascade["size"], cascade["length_m"], state["depth_m"]))
        keyframe.add(tile)
        self.arrived.append(keyframe)
        wanted = [f for f in range(32) if (self.granted or {}).get("fields", 0) >> f & 1]
        if wanted and keyframe.holds(wanted):
            self.complete.append(tile["keyframe"])
            self.acknowledge(min(self.granted["credit"] // 2, self.welcome["keyframes_per_ack_max"]))

    def acknowledge(self, together):
        """All that are complete, once they are so many."""
        if len(self.complete) >= max(together, 1):
            first, *also = self.complete
            self.complete = []
            self.send("Ack", keyframe=first, also=also or None)

    def wait_for(self, kind, request_id=None):
        while True:
            message = self.receive()
            if message["kind"] == "Refused" and message["request_id"] == request_id:
                raise Refused(message)
            if message["kind"] == kind and message.get("request_id") == (request_id or message.get("request_id")):
                return message

    def ask(self, kind, reply, **values):
        self.last_id += 1
        self.send(kind, request_id=self.last_id, **values)
        return self.wait_for(reply, self.last_id)

    def subscribe(self, fields=SURFACE_FIELDS, error_m=0.0, credit=8, rate_hz_max=0.0, size_max=0):
        """Has tiles streamed; returns when the present can be sampled."""
        self.ask("Subscribe", "FetchDone", cascades=0xFFFFFFFF, fields=fields, error_m=error_m, credit=credit,
                 compact=self.compact, rate_hz_max=rate_hz_max, size_max=size_max)
        return self.granted

    def subscribe_spectrum(self, error_m=0.0, slope_error=0.0, fields=0):
        """Has the waves sent; returns what was granted when all of them are there."""
        granted = self.ask("SubscribeSpectrum", "SpectrumSubscribed", error_m=error_m, slope_error=slope_error,
                           fields=fields)
        while sum(spectrum.whole for spectrum in self.spectra.values()) < granted["spectra"]:
            self.receive()
        return granted

    def fetch(self, times_us, fields=SURFACE_FIELDS, error_m=0.0):
        return self.ask("Fetch", "FetchDone", times_us=times_us, fields=fields, error_m=error_m, compact=self.compact)

    def query(self, points, exact=False, min_wavelength_m=0.0):
        """points: (x_m, y_m, time_us)."""
        listed = [{"x_m": x, "y_m": y, "time_us": t} for x, y, t in points]
        reply = self.ask("Query", "QueryReply", exact=exact, points=listed, min_wavelength_m=min_wavelength_m)
        if min_wavelength_m > 0 and reply.get("cascades") is None:
            raise ValueError("this server has answered for all waves")
        return reply["answers"]

    def query_below(self, points):
        """points: (x_m, y_m, time_us, z_m); the surface above each, and the water at each."""
        listed = [{"x_m": x, "y_m": y, "time_us": t} for x, y, t, _ in points]
        reply = self.ask("Query", "QueryReply", points=listed, z_m=[z for _, _, _, z in points])
        return reply["answers"], reply["below"]

    def sea_time_us(self):
        return self.ask("Ping", "Pong", client_time_us=0)["sea_time_us"]

    def state_at(self, time_us):
        states = sorted(self.states.values(), key=lambda state: state["start_time_us"])
        running = [state for state in states if state["start_time_us"] <= time_us]
        return running[-1] if running else states[0]

    def pairs(self, time_us):
        """The two keyframes of every cascade around a time, or None if some are not held."""
        state = self.state_at(time_us)
        pairs = []
        for number, cascade in enumerate(state["cascades"]):
            mine = {t: k for (epoch, c, t), k in self.keyframes.items() if (epoch, c) == (state["epoch"], number)}
            before = max((t for t in mine if t <= time_us), default=None)
            after = min((t for t in mine if t > time_us), default=None)
            if before is None or after is None:
                return None
            apart = max(mine[t].coarser["interval_us"] for t in (before, after))
            if after - before > max(apart, cascade["interval_us"]):
                return None
            pairs.append(((before, mine[before]), (after, mine[after])))
        return pairs

    def surface(self, time_us):
        return surface.Surface(self.state_at(time_us), self.pairs(time_us), time_us)

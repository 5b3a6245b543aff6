# SPDX-License-Identifier: Apache-2.0
"""FlatBuffers by hand: reads protocol/seaway.fbs, then messages by it, both ways.

Written from docs/protocol.md, "Reading and writing FlatBuffers by hand". Messages are dictionaries;
a body is {"kind": "Ping", "request_id": 10, ...}. Fields that are absent have their defaults, and
strings, lists and structs that are absent are None.
"""
import re
import struct

SCALARS = {"bool": "?", "byte": "b", "ubyte": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I",
           "long": "q", "ulong": "Q", "float": "f", "double": "d"}
IDENTIFIER = b"SEAW"


class Schema:
    """Structs and tables as lists of (name, type, default), enums as {name: number}."""

    def __init__(self, text):
        text = re.sub(r"//[^\n]*", "", text)
        self.structs, self.tables, self.enums, self.enum_types = {}, {}, {}, {}
        for kind, name, body in re.findall(r"\b(struct|table)\s+(\w+)\s*{([^}]*)}", text):
            fields = re.findall(r"(\w+)\s*:\s*(\[?\w+\]?)\s*(?:=\s*([\w.]+))?\s*(?:\([^)]*\))?\s*;", body)
            (self.structs if kind == "struct" else self.tables)[name] = fields
        for name, base, body in re.findall(r"\benum\s+(\w+)\s*:\s*(\w+)\s*{([^}]*)}", text):
            self.enums[name] = {n: int(v) for n, v in re.findall(r"(\w+)\s*=\s*(\d+)", body)}
            self.enum_types[name] = base
        bodies = re.search(r"\bunion\s+Body\s*{([^}]*)}", text)[1]
        self.bodies = ["NONE"] + re.findall(r"\w+", bodies)  # the number of a kind is its place

    def scalar(self, kind):
        """The struct code of a scalar or enum, None for anything else."""
        return SCALARS.get(self.enum_types.get(kind, kind))

    def struct_layout(self, name):
        """([(member, code, offset)], size): members lie at multiples of their own size."""
        at, widest, members = 0, 1, []
        for member, kind, _ in self.structs[name]:
            size = struct.calcsize("<" + self.scalar(kind))
            at = -(-at // size) * size
            members.append((member, self.scalar(kind), at))
            at, widest = at + size, max(widest, size)
        return members, -(-at // widest) * widest

    # ---- reading ---------------------------------------------------------------------------------

    def read_message(self, data):
        if data[4:8] != IDENTIFIER:
            raise ValueError("not a seaway message")
        root = self._u32(data, 0)
        number = self._field(data, root, 0)
        body = self._field(data, root, 1)
        kind_number = data[number]
        if kind_number >= len(self.bodies):
            return {"kind": None}  # of a later version: to be skipped
        kind = self.bodies[kind_number]
        return {"kind": kind, **self._table(data, body + self._u32(data, body), kind)}

    @staticmethod
    def _u32(data, at):
        return struct.unpack_from("<I", data, at)[0]

    @staticmethod
    def _field(data, table, slot):
        """Where field number `slot` lies; 0 if it is absent."""
        vtable = table - struct.unpack_from("<i", data, table)[0]
        entry = 4 + 2 * slot
        if entry + 2 > struct.unpack_from("<H", data, vtable)[0]:
            return 0
        offset = struct.unpack_from("<H", data, vtable + entry)[0]
        return table + offset if offset else 0

    def _table(self, data, table, name):
        values = {}
        for slot, (field, kind, default) in enumerate(self.tables[name]):
            at = self._field(data, table, slot)
            code = self.scalar(kind)
            if code:
                values[field] = (struct.unpack_from("<" + code, data, at)[0] if at
                                 else None if default == "null" else int(default, 0) if default else 0)
            elif not at:
                values[field] = None
            elif kind in self.structs:
                values[field] = self._struct(data, at, kind)
            else:
                values[field] = self._reference(data, at + self._u32(data, at), kind)
        return values

    def _struct(self, data, at, name):
        return {member: struct.unpack_from("<" + code, data, at + offset)[0]
                for member, code, offset in self.struct_layout(name)[0]}

    def _reference(self, data, at, kind):
        count = self._u32(data, at)
        if kind == "string":
            return bytes(data[at + 4:at + 4 + count]).decode()
        element = kind.strip("[]")
        if element == "ubyte":
            return bytes(data[at + 4:at + 4 + count])
        if element == "string":
            places = [at + 4 + 4 * i for i in range(count)]
            return [self._reference(data, place + self._u32(data, place), "string") for place in places]
        if element in self.structs:
            size = self.struct_layout(element)[1]
            return [self._struct(data, at + 4 + size * i, element) for i in range(count)]
        return list(struct.unpack_from(f"<{count}{self.scalar(element)}", data, at + 4))

    # ---- writing ---------------------------------------------------------------------------------

    def write_message(self, kind, **values):
        out = bytearray(8)
        out[4:8] = IDENTIFIER
        unknown = values.keys() - {name for name, _, _ in self.tables[kind]}
        if unknown:
            raise KeyError(f"{kind} has no {unknown}")
        root, places = self._write_inline(out, [("B", self.bodies.index(kind)), ("ref", 0)])
        struct.pack_into("<I", out, 0, root)
        self._point(out, places[1], self._write_table(out, kind, values))
        return bytes(out)

    @staticmethod
    def _point(out, place, target):
        struct.pack_into("<I", out, place, target - place)

    @staticmethod
    def _pad(out, multiple, ahead=0):
        """So that what begins `ahead` bytes from here lies at a multiple."""
        out.extend(bytes(-(len(out) + ahead) % multiple))

    def _write_inline(self, out, slots):
        """A vtable and its table; slots are (code, value) or None. Returns where the table and the
        slots lie."""
        self._pad(out, 2)
        vtable = len(out)
        out.extend(bytes(4 + 2 * len(slots)))
        self._pad(out, 8)
        table = len(out)
        out.extend(struct.pack("<i", table - vtable))
        places = []
        for slot, entry in enumerate(slots):
            if entry is None:
                places.append(0)
                continue
            code = "I" if entry[0] == "ref" else entry[0]
            self._pad(out, struct.calcsize("<" + code))
            places.append(len(out))
            struct.pack_into("<H", out, vtable + 4 + 2 * slot, len(out) - table)
            out.extend(struct.pack("<" + code, entry[1]))
        struct.pack_into("<HH", out, vtable, 4 + 2 * len(slots), len(out) - table)
        return table, places

    def _write_table(self, out, name, values):
        fields = self.tables[name]
        slots = [None if values.get(field) is None else (self.scalar(kind) or "ref", values[field]
                                                   if self.scalar(kind) else 0)
                 for field, kind, _ in fields]
        table, places = self._write_inline(out, slots)
        for (field, kind, _), place in zip(fields, places):
            if place and not self.scalar(kind):
                self._point(out, place, self._write_reference(out, kind, values[field]))
        return table

    def _write_reference(self, out, kind, value):
        self._pad(out, 8, ahead=4)  # the elements, of whatever size, lie at multiples of 8
        at = len(out)
        if kind == "string":
            text = value.encode()
            out.extend(struct.pack("<I", len(text)) + text + b"\0")
            return at
        element = kind.strip("[]")
        out.extend(struct.pack("<I", len(value)))
        if element in self.structs:
            members, size = self.struct_layout(element)
            for one in value:
                begin = len(out)
                out.extend(bytes(size))
                for member, code, offset in members:
                    struct.pack_into("<" + code, out, begin + offset, one[member])
        else:
            out.extend(struct.pack(f"<{len(value)}{self.scalar(element)}", *value))
        return at

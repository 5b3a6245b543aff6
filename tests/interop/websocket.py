# SPDX-License-Identifier: Apache-2.0
"""The client's side of a WebSocket (RFC 6455) over a plain socket: binary messages, pings, closes."""
import base64
import hashlib
import os
import socket
import struct

CONTINUED, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10
ACCEPT = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


class Closed(Exception):
    """The peer's close frame; `code` is None where the connection went without one."""

    def __init__(self, code, reason=""):
        super().__init__(f"closed: {code} {reason}")
        self.code = code


class HandshakeFailed(Exception):
    def __init__(self, status):
        super().__init__(f"the server answers {status}")
        self.status = status


class WebSocket:
    def __init__(self, host, port, path, subprotocol, timeout_s=120):
        self.socket = socket.create_connection((host, port), timeout=timeout_s)
        self.received = b""
        key = base64.b64encode(os.urandom(16)).decode()
        offer = f"Sec-WebSocket-Protocol: {subprotocol}\r\n" if subprotocol else ""
        self.socket.sendall((f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
                             f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n{offer}"
                             "Sec-WebSocket-Version: 13\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.received:
            self._receive_some()
        head, self.received = self.received.split(b"\r\n\r\n", 1)
        lines = head.decode().split("\r\n")
        status = int(lines[0].split()[1])
        if status != 101:
            self.socket.close()
            raise HandshakeFailed(status)
        headers = {k.strip().lower(): v.strip() for k, v in (line.split(":", 1) for line in lines[1:])}
        accept = base64.b64encode(hashlib.sha1((key + ACCEPT).encode()).digest()).decode()
        if headers["sec-websocket-accept"] != accept or headers["sec-websocket-protocol"] != subprotocol:
            raise HandshakeFailed("a wrong key or subprotocol")

    def _receive_some(self):
        some = self.socket.recv(1 << 16)
        if not some:
            raise Closed(None)
        self.received += some

    def _take(self, count):
        while len(self.received) < count:
            self._receive_some()
        taken, self.received = self.received[:count], self.received[count:]
        return taken

    def send(self, payload, opcode=BINARY, masked=True, announced=None):
        """`masked` and `announced`, a length that is not the payload's, are for breaking the rules."""
        count = len(payload) if announced is None else announced
        mask_bit = 0x80 if masked else 0
        if count < 126:
            head = struct.pack(">BB", 0x80 | opcode, mask_bit | count)
        elif count < 1 << 16:
            head = struct.pack(">BBH", 0x80 | opcode, mask_bit | 126, count)
        else:
            head = struct.pack(">BBQ", 0x80 | opcode, mask_bit | 127, count)
        if masked:
            mask = os.urandom(4)
            payload = mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        self.socket.sendall(head + payload)

    def receive(self):
        """The next binary message, whole; answers pings on the way."""
        message = b""
        while True:
            first, second = self._take(2)
            count = second & 0x7F
            if count == 126:
                count, = struct.unpack(">H", self._take(2))
            elif count == 127:
                count, = struct.unpack(">Q", self._take(8))
            payload = self._take(count)
            opcode = first & 0x0F
            if opcode == PING:
                self.send(payload, PONG)
            elif opcode == CLOSE:
                code, = struct.unpack(">H", payload[:2]) if len(payload) >= 2 else (None,)
                raise Closed(code, payload[2:].decode(errors="replace"))
            elif opcode in (BINARY, CONTINUED):
                message += payload
                if first & 0x80:
                    return message

    def close(self):
        self.socket.close()

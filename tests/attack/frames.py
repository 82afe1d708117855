"""HTTP/2 as bytes, for what no gRPC client would send."""

import os
import socket
import ssl
import struct

# Behind a router: its authority. The attacker then comes from an address of its own, as the router's
# limits go by it.
ROUTER_CA = os.environ.get("DCLOC_ATTACK_CA")
ATTACKER = "127.0.0.2"

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, CONTINUATION = 0, 1, 3, 4, 9
END_STREAM, END_HEADERS, ACK = 1, 4, 1
CANCEL = 8


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload


def _text(text):
    return struct.pack(">B", len(text)) + text.encode()


def call_headers(method, token=None):
    """The header block of a gRPC call; literals that no table keeps."""
    fields = [(":method", "POST"), (":scheme", "http"), (":path", method), (":authority", "dcloc"),
              ("content-type", "application/grpc"), ("te", "trailers")]
    if token:
        fields.append(("authorization", f"Bearer {token}"))
    return header_block(fields)


def header_block(fields):
    """Header fields as literals that no table keeps."""
    return b"".join(b"\x00" + _text(name) + _text(value) for name, value in fields)


def connect_silently(address, timeout_s=5):
    """A connection that has said nothing; to a router from the attacker's own address."""
    host, _, port = address.rpartition(":")
    source = (ATTACKER, 0) if ROUTER_CA else None
    return socket.create_connection((host, int(port)), timeout_s, source)


def connect(address, timeout_s=5):
    """A connection of HTTP/2, greeted."""
    connection = connect_silently(address, timeout_s)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if ROUTER_CA:
        context = ssl.create_default_context(cafile=ROUTER_CA)
        context.set_alpn_protocols(["h2"])
        connection = context.wrap_socket(connection, server_hostname="localhost")
    connection.sendall(PREFACE + frame(SETTINGS, 0, 0))
    return connection


def message(payload):
    """As gRPC frames a message."""
    return struct.pack(">BI", 0, len(payload)) + payload

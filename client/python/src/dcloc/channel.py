"""A channel with the limits and keepalive that suit a dcloc server."""

from __future__ import annotations

import ipaddress
import pathlib
from typing import Any, Callable

import grpc

_OPTIONS = [
    ("grpc.max_send_message_length", 2 << 20),
    ("grpc.max_receive_message_length", 2 << 20),
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.http2.max_pings_without_data", 0),
]


def is_loopback(server: str) -> bool:
    """Whether HOST:PORT is this machine."""
    host = server.rpartition(":")[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def read_token(path: str | pathlib.Path) -> str:
    """The one word in the file; an error names the file, never what is in it."""
    token = pathlib.Path(path).read_bytes().rstrip()
    if not token or len(token) > 4096 or any(not 0x20 < byte < 0x7f for byte in token):
        raise ValueError(f"token_file: {path}: must hold one word of 1 to 4096 printable ASCII "
                         f"characters, and has {len(token)} bytes")
    return token.decode()


class _Details(grpc.ClientCallDetails):
    def __init__(self, details: grpc.ClientCallDetails, metadata: list[tuple[str, str]]) -> None:
        self.method = details.method
        self.timeout = details.timeout
        self.metadata = metadata
        self.credentials = details.credentials
        self.wait_for_ready = details.wait_for_ready
        self.compression = details.compression


class _SendToken(grpc.UnaryUnaryClientInterceptor, grpc.UnaryStreamClientInterceptor,
                 grpc.StreamUnaryClientInterceptor, grpc.StreamStreamClientInterceptor):
    """Sends the token with each call, over TLS and loopback alike."""

    def __init__(self, token: str) -> None:
        self._entry = ("authorization", f"Bearer {token}")

    def _call(self, continuation: Callable[..., Any], details: grpc.ClientCallDetails,
              request: Any) -> Any:
        return continuation(_Details(details, [*(details.metadata or []), self._entry]), request)

    intercept_unary_unary = _call
    intercept_unary_stream = _call
    intercept_stream_unary = _call
    intercept_stream_stream = _call


def connect(server: str, *, tls_ca: str | pathlib.Path | None = None,
            tls_cert: str | pathlib.Path | None = None, tls_key: str | pathlib.Path | None = None,
            tls_server_name: str | None = None,
            token_file: str | pathlib.Path | None = None) -> grpc.Channel:
    """A channel to HOST:PORT. With `tls_ca` over TLS, else in plaintext; `tls_cert` and `tls_key`
    are the client's own, where the server asks for them. A token is sent over TLS, or in plaintext
    to this very machine."""
    if (tls_cert is None) != (tls_key is None):
        raise ValueError("tls_cert and tls_key go together; only one is given")
    if tls_ca is None and (tls_cert or tls_server_name):
        raise ValueError("TLS needs tls_ca, the authority of the server's certificate")
    options: list[tuple[str, Any]] = list(_OPTIONS)
    if tls_server_name:
        options.append(("grpc.ssl_target_name_override", tls_server_name))
    if tls_ca is not None:
        def read(path: str | pathlib.Path | None) -> bytes | None:
            return None if path is None else pathlib.Path(path).read_bytes()
        credentials = grpc.ssl_channel_credentials(read(tls_ca), read(tls_key), read(tls_cert))
        channel = grpc.secure_channel(server, credentials, options)
    else:
        if token_file is not None and not is_loopback(server):
            raise ValueError(f"token_file is given and server is {server}, another machine: a token "
                             "is not sent there in plaintext; TLS needs tls_ca")
        if is_loopback(server):
            options.append(("grpc.enable_http_proxy", 0))
        channel = grpc.insecure_channel(server, options)
    if token_file is None:
        return channel
    return grpc.intercept_channel(channel, _SendToken(read_token(token_file)))

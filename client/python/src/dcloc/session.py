"""One vehicle's localization session."""

from __future__ import annotations

import queue
from types import TracebackType
from typing import Iterator

import grpc

from dcloc.v1 import localization_service_pb2 as messages
from dcloc.v1 import localization_service_pb2_grpc as stubs
from dcloc.v1 import scan_pb2


class Session:
    """Scans and position fixes in, exactly one answer to each out, in the same order.

    Over one stream: when the connection breaks, a call raises grpc.RpcError, and a resumable
    session can be gone on with by opening one with `opened.resume_token`. One thread may send while
    another one takes answers.
    """

    def __init__(self, channel: grpc.Channel, open_session: messages.OpenSession) -> None:
        """Waits until the session is open; grpc.RpcError says why it cannot be."""
        self._requests: queue.SimpleQueue[messages.LocalizeRequest | None] = queue.SimpleQueue()
        self._requests.put(messages.LocalizeRequest(open=open_session))
        self._answers = stubs.LocalizationServiceStub(channel).Localize(
            iter(self._requests.get, None),
            metadata=[("x-session-id", open_session.vehicle_id)])
        # gRPC takes the requests on a thread of its own, which would wait for the next one for good.
        if not self._answers.add_callback(lambda: self._requests.put(None)):
            self._requests.put(None)
        #: What the server said on opening.
        self.opened: messages.SessionOpened = next(self._answers).opened

    def send(self, scan: scan_pb2.Scan) -> None:
        """Queues a scan. Does not wait."""
        self._requests.put(messages.LocalizeRequest(scan=scan))

    def send_fix(self, fix: messages.PositionFix) -> None:
        """Queues a position fix behind the scans that were sent before it. Does not wait.

        Its answer, a `position_fix_answer`, comes in its turn. It must not be sent again on another
        stream. NotImplementedError when the server is too old to take any.
        """
        if not self.opened.takes_position_fixes:
            raise NotImplementedError("the server takes no position fixes; it is an older one")
        self._requests.put(messages.LocalizeRequest(position_fix=fix))

    def close_sending(self) -> None:
        """Says that no more scans will come, and that the session is not to be resumed."""
        self._requests.put(messages.LocalizeRequest(close=messages.CloseSession()))
        self._requests.put(None)

    def __iter__(self) -> Iterator[messages.LocalizeResponse]:
        """The answers, until the session ends; grpc.RpcError when it does not end well."""
        return (answer for answer in self._answers if not answer.HasField("ending"))

    def localize(self, scan: scan_pb2.Scan) -> messages.LocalizeResponse:
        """Sends a scan and waits for its answer, a `result` or `rejected`.

        Answers to position fixes that were sent before it, and not taken yet, are passed over.
        """
        self.send(scan)
        return next(answer for answer in self if not answer.HasField("position_fix_answer"))

    def cancel(self) -> None:
        """Ends the stream without waiting. A resumable session stays, for a while."""
        self._requests.put(None)
        self._answers.cancel()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, error: type[BaseException] | None, value: BaseException | None,
                 trace: TracebackType | None) -> None:
        if error is not None:
            self.cancel()
            return
        self.close_sending()
        for _ in self:
            pass

"""The HTTP client under that of openai: what comes from an endpoint is bounded in size and in time."""

import time
from collections.abc import Iterator

import httpx2
import openai

from roadmend.core.bounds import Bounds


class TooLargeError(openai.OpenAIError):
    """An endpoint sends more than anybody asked for; of this kind since the client does not try such again."""


class _BoundedStream(httpx2.SyncByteStream):
    """A body that may not grow beyond a size, nor trickle on after a deadline."""

    def __init__(self, stream: httpx2.SyncByteStream, largest: int, deadline: float) -> None:
        self.stream = stream
        self.largest = largest
        self.deadline = deadline

    def __iter__(self) -> Iterator[bytes]:
        size = 0
        for chunk in self.stream:
            size += len(chunk)
            if size > self.largest:
                raise TooLargeError(f"more than {self.largest / 1e6:g} MB")
            if time.monotonic() > self.deadline:
                raise httpx2.ReadTimeout("the answer goes on for too long")
            yield chunk

    def close(self) -> None:
        self.stream.close()


def bounded_client(timeout: float, bounds: Bounds) -> httpx2.Client:
    """A client that asks for plain bodies and stops reading where they become too large or take too long.

    Args:
        timeout: [s] for a body, beside that of each single piece of it.
        bounds: of a body.
    """

    def bound(response: httpx2.Response) -> None:
        if response.headers.get("content-encoding", "identity").lower() != "identity":
            raise TooLargeError("a compressed body, though a plain one was asked for")  # may unpack to any size
        if isinstance(response.stream, httpx2.SyncByteStream):
            response.stream = _BoundedStream(response.stream, bounds.size, time.monotonic() + timeout)

    return openai.DefaultHttpx2Client(
        timeout=timeout, headers={"Accept-Encoding": "identity"}, event_hooks={"response": [bound]}
    )

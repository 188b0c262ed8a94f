"""A gate before a WebSocket server that asks nobody where they come from: web pages that are not invited stay out.

Every page in a browser may open a WebSocket to this machine, and none of the browser's same-origin rules stop it. The
browser does say which page it is, in the header ``Origin`` of the handshake. The gate reads that and passes on what
is allowed, byte by byte, to the server behind it.

It also lets in viewers that know the protocol by its older name alone, as Lichtblick and the older Foxglove do: the
messages are the same, but the server behind answers to the newer name only.
"""

import asyncio
import contextlib
import errno
import re
import secrets
import threading
from collections.abc import Collection, Iterator

from roadmend.core.errors import InputError

HEAD_LIMIT = 16384  # [bytes] a longer request is none of a browser's
HEAD_PATIENCE_S = 5.0  # [s] for the request to arrive
_CHUNK = 65536  # [bytes]
_WEB = re.compile(rb"(?:https?|wss?)://|null$", re.IGNORECASE)  # a page's origin, or that of a page that hides it
_ORIGIN = re.compile(rb"\r\norigin[ \t]*:[ \t]*([^\r\n]*?)[ \t]*(?=\r\n)", re.IGNORECASE)
_OLDER, _NEWER = b"foxglove.websocket.v1", b"foxglove.sdk.v1"  # names of the protocol, in a handshake
_OFFER = re.compile(rb"(\r\nsec-websocket-protocol[ \t]*:[ \t]*)([^\r\n]*)(?=\r\n)", re.IGNORECASE)
_REFUSAL = (
    b"HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain\r\nConnection: close\r\n\r\nThis origin is not allowed.\n"
)


def hidden_address() -> str:
    """A loopback address drawn at random, for a server that only the gate shall find.

    All of 127.0.0.0/8 is this machine, and a page can only try address by address and port by port.
    """
    return f"127.{secrets.randbelow(254) + 1}.{secrets.randbelow(254) + 1}.{secrets.randbelow(254) + 1}"


def may_enter(head: bytes, allowed: Collection[str]) -> bool:
    """Whether a handshake comes from an allowed page, or from no page at all.

    Programs send no Origin; desktop applications one with a scheme of their own.

    Args:
        head: the request up to and including the empty line.
        allowed: origins of pages, such as ``https://app.foxglove.dev``.
    """
    invited = {origin.encode() for origin in allowed}
    return all(origin in invited or not _WEB.match(origin) for origin in _ORIGIN.findall(head))


def offers_older_alone(head: bytes) -> bool:
    """Whether a handshake asks for the protocol by its older name and not by the newer one."""
    offers = {name.strip() for _, names in _OFFER.findall(head) for name in names.split(b",")}
    return _OLDER in offers and _NEWER not in offers


def renamed(head: bytes, before: bytes, after: bytes) -> bytes:
    """A handshake, or the answer to one, in which the protocol has another name; the rest stays as it is."""
    return _OFFER.sub(lambda found: found[1] + found[2].replace(before, after), head)


class OriginGate:
    """Listens on one address and passes what may enter on to another; runs in a thread of its own.

    Args:
        address: where to listen.
        port: where to listen; 0 takes a free one.
        target: address and port of the server behind.
        allowed: origins of the web pages that may enter.

    Raises:
        InputError: the port is taken or the address is none of this machine's.
    """

    def __init__(self, address: str, port: int, target: tuple[str, int], allowed: Collection[str]) -> None:
        self.refused = 0  # requests that were turned away
        self._target = target
        self._allowed = allowed
        self._answering = threading.Lock()  # what the server says is passed on only by who holds it
        self._loop = asyncio.new_event_loop()
        try:
            self._server = self._loop.run_until_complete(
                asyncio.start_server(self._receive, address, port, limit=HEAD_LIMIT)
            )
        except OSError as error:
            self._loop.close()
            what = "is in use" if error.errno == errno.EADDRINUSE else f"cannot be listened on ({error.strerror})"
            raise InputError(f"{address}:{port}", what, "choose another port or address") from error
        self.port: int = self._server.sockets[0].getsockname()[1]
        self._thread = threading.Thread(target=self._loop.run_forever, name="origin-gate", daemon=True)
        self._thread.start()

    @contextlib.contextmanager
    def held_back(self) -> Iterator[None]:
        """What the server says meanwhile reaches the viewers afterwards: for moments, since all of them wait."""
        with self._answering:
            yield

    def close(self) -> None:
        """Stop listening and drop who is there. Does nothing the second time."""
        if self._loop.is_closed():
            return
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.run_until_complete(self._end())
        self._loop.close()

    async def _end(self) -> None:
        self._server.close()
        left = asyncio.all_tasks() - {asyncio.current_task()}
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)

    async def _receive(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            try:
                head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), HEAD_PATIENCE_S)
                if may_enter(head, self._allowed):
                    await self._pass_on(head, reader, writer)
                else:
                    self.refused += 1
                    writer.write(_REFUSAL)
                    await writer.drain()
            finally:
                writer.close()

    async def _pass_on(self, head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        inner_reader, inner_writer = await asyncio.open_connection(*self._target)
        try:
            is_older = offers_older_alone(head)
            inner_writer.write(renamed(head, _OLDER, _NEWER) if is_older else head)
            if is_older:
                answer = await inner_reader.readuntil(b"\r\n\r\n")
                writer.write(renamed(answer, _NEWER, _OLDER))
            ways = [
                asyncio.ensure_future(_pump(reader, inner_writer, contextlib.nullcontext())),
                asyncio.ensure_future(_pump(inner_reader, writer, self._answering)),
            ]
            try:
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for way in ways:
                    way.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
        finally:
            inner_writer.close()


async def _pump(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, turn: contextlib.AbstractContextManager[object]
) -> None:
    while data := await reader.read(_CHUNK):
        with turn:
            writer.write(data)
        await writer.drain()

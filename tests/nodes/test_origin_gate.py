"""The gate before the live server: real sockets on both sides."""

import contextlib
import ipaddress
import select
import socket
import threading
import time

import pytest

from roadmend.core.errors import InputError
from roadmend.nodes.origin_gate import (
    HEAD_LIMIT,
    OriginGate,
    hidden_address,
    may_enter,
    offers_older_alone,
    renamed,
)

ALLOWED = ["https://app.foxglove.dev"]


def handshake(*headers):
    return "\r\n".join(["GET / HTTP/1.1", "Host: localhost:8765", *headers, "", ""]).encode()


@pytest.mark.parametrize(
    "headers",
    [
        [],  # a program
        ["Origin: https://app.foxglove.dev"],
        ["origin:https://app.foxglove.dev  "],
        ["Origin: file://"],  # desktop applications
        ["Origin: app://foxglove"],
        ["Referer: https://evil.example"],
    ],
)
def test_programs_and_invited_pages_enter(headers):
    assert may_enter(handshake(*headers), ALLOWED)


@pytest.mark.parametrize(
    "headers",
    [
        ["Origin: https://evil.example"],
        ["ORIGIN: HTTPS://evil.example"],
        ["Origin: http://localhost:3000"],
        ["Origin: http://app.foxglove.dev"],
        ["Origin: https://app.foxglove.dev.evil.example"],
        ["Origin: https://app.foxglove.dev:444"],
        ["Origin: null"],  # what a page in a sandboxed frame sends
        ["Origin: https://app.foxglove.dev", "Origin: https://evil.example"],
    ],
)
def test_other_pages_stay_out(headers):
    assert not may_enter(handshake(*headers), ALLOWED)


def test_hidden_addresses_are_loopback_and_differ():
    addresses = {hidden_address() for _ in range(50)}
    assert len(addresses) > 45
    assert all(ipaddress.ip_address(address).is_loopback for address in addresses)


@pytest.fixture
def behind():
    """A server that answers each piece with the same in capitals; its address and what it received."""
    heard = []

    def serve(listening):
        with contextlib.suppress(OSError):
            while True:
                connection, _ = listening.accept()
                with connection:
                    while data := connection.recv(4096):
                        heard.append(data)
                        connection.sendall(data.upper())

    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=serve, args=[listening], daemon=True).start()
        yield listening.getsockname(), heard


@pytest.fixture
def gate(behind):
    gate = OriginGate("127.0.0.1", 0, behind[0], ALLOWED)
    yield gate
    gate.close()
    gate.close()


def connect(gate):
    return socket.create_connection(("127.0.0.1", gate.port), timeout=20)


def everything(connection):
    return b"".join(iter(lambda: connection.recv(4096), b""))


def test_what_enters_is_passed_both_ways_unchanged(gate, behind):
    with connect(gate) as connection:
        connection.sendall(handshake() + b"more")
        assert connection.recv(4096).startswith(b"GET / HTTP/1.1\r\nHOST: LOCALHOST")
        connection.sendall(b"\x00abc")
        while not b"".join(behind[1]).endswith(b"abc"):
            assert connection.recv(4096)
        connection.shutdown(socket.SHUT_WR)
        everything(connection)
    assert b"".join(behind[1]) == handshake() + b"more\x00abc"
    assert gate.refused == 0


def test_what_the_server_says_while_it_is_held_back_comes_afterwards(gate, behind):
    with connect(gate) as connection:
        connection.sendall(handshake())
        assert connection.recv(4096).startswith(b"GET / HTTP/1.1")
        with gate.held_back():
            connection.sendall(b"said")
            while not b"".join(behind[1]).endswith(b"said"):  # which the server answers at once
                time.sleep(0.01)
            assert select.select([connection], [], [], 0.3)[0] == []
        assert connection.recv(4096).endswith(b"SAID")


def test_a_page_is_turned_away_and_the_server_hears_nothing_of_it(gate, behind):
    with connect(gate) as connection:
        connection.sendall(handshake("Origin: https://evil.example"))
        assert everything(connection).startswith(b"HTTP/1.1 403 Forbidden\r\n")
    assert gate.refused == 1
    assert behind[1] == []


def test_a_request_without_end_is_dropped(gate, behind):
    with connect(gate) as connection, contextlib.suppress(ConnectionError):
        connection.sendall(b"x" * 4 * HEAD_LIMIT)
        assert everything(connection) == b""
    assert behind[1] == []


def test_a_server_that_is_gone_ends_the_connection():
    with socket.create_server(("127.0.0.1", 0)) as gone:
        target = gone.getsockname()
    gate = OriginGate("127.0.0.1", 0, target, ALLOWED)
    with connect(gate) as connection:
        connection.sendall(handshake())
        assert everything(connection) == b""
    gate.close()


def test_closing_drops_who_is_there(behind):
    gate = OriginGate("127.0.0.1", 0, behind[0], ALLOWED)
    with connect(gate) as connection:
        connection.sendall(handshake())
        connection.recv(4096)
        gate.close()
        everything(connection)
    with pytest.raises(OSError):
        connect(gate)


def test_a_port_in_use_and_a_foreign_address_are_one_line(gate):
    with pytest.raises(InputError, match=rf"^127.0.0.1:{gate.port}: is in use; choose another port or address$"):
        OriginGate("127.0.0.1", gate.port, ("127.0.0.1", 1), ALLOWED)
    with pytest.raises(InputError, match=r"^192.0.2.1:0: cannot be listened on \("):
        OriginGate("192.0.2.1", 0, ("127.0.0.1", 1), ALLOWED)


OLDER, NEWER = "foxglove.websocket.v1", "foxglove.sdk.v1"


@pytest.mark.parametrize(
    ("headers", "is_older"),
    [
        ([f"Sec-WebSocket-Protocol: {OLDER}"], True),
        ([f"sec-websocket-protocol:x, {OLDER} , y"], True),
        ([f"Sec-WebSocket-Protocol: {OLDER}, {NEWER}"], False),
        ([f"Sec-WebSocket-Protocol: {OLDER}", f"Sec-WebSocket-Protocol: {NEWER}"], False),
        ([f"Sec-WebSocket-Protocol: {NEWER}"], False),
        ([f"X-Other: {OLDER}"], False),
        ([], False),
    ],
)
def test_who_knows_the_older_name_alone(headers, is_older):
    assert offers_older_alone(handshake(*headers)) is is_older


def test_only_the_protocol_is_renamed():
    head = handshake(f"X-Other: {OLDER}", f"Sec-WebSocket-Protocol: x, {OLDER}", "Host: b")
    wanted = handshake(f"X-Other: {OLDER}", f"Sec-WebSocket-Protocol: x, {NEWER}", "Host: b")
    assert renamed(head, OLDER.encode(), NEWER.encode()) == wanted


def test_a_viewer_with_the_older_name_is_answered_by_it_and_the_rest_passes_unchanged():
    heard = []

    def serve(listening):
        connection, _ = listening.accept()
        with connection:
            heard.append(connection.recv(4096))
            answer = f"HTTP/1.1 101 Switching Protocols\r\nSec-WebSocket-Protocol: {NEWER}\r\n\r\n{NEWER}"
            connection.sendall(answer.encode())

    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=serve, args=[listening], daemon=True)
        thread.start()
        gate = OriginGate("127.0.0.1", 0, listening.getsockname(), ALLOWED)
        with connect(gate) as connection:
            connection.sendall(handshake(f"Sec-WebSocket-Protocol: {OLDER}"))
            answer = everything(connection)
        thread.join()
        gate.close()
    assert heard == [handshake(f"Sec-WebSocket-Protocol: {NEWER}")]
    told = f"HTTP/1.1 101 Switching Protocols\r\nSec-WebSocket-Protocol: {OLDER}\r\n\r\n{NEWER}"
    assert answer == told.encode()

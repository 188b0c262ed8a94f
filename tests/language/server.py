"""A server on this machine that speaks OpenAI's protocol for chat and embeddings, as far as the client uses it."""

import json
import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

WAIT = "wait"


def completion(content, **changes):
    """The body of a chat completion."""
    message = {"role": "assistant", "content": content, "refusal": None} | changes.pop("message", {})
    choice = {"index": 0, "finish_reason": "stop", "message": message} | changes.pop("choice", {})
    return {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 1,
        "model": "test-model-1",
        "choices": [choice],
        "usage": {"prompt_tokens": 1000, "completion_tokens": 50, "total_tokens": 1050},
    } | changes


def parts(body):
    """The parts of a request's messages, in their order."""
    for message in body["messages"]:
        content = message["content"]
        yield from [{"type": "text", "text": content}] if isinstance(content, str) else content


def texts(body):
    """The texts of a request's messages."""
    return [part["text"] for part in parts(body) if part["type"] == "text"]


def images(body):
    """The pictures of a request's messages."""
    return [part for part in parts(body) if part["type"] == "image_url"]


def embeddings(encode):
    """Answers a request for embeddings with what a function makes of each text; in reverse, for the index counts."""

    def answer(body):
        assert body["encoding_format"] == "float"
        data = [
            {"object": "embedding", "index": index, "embedding": encode(text)}
            for index, text in enumerate(body["input"])
        ]
        usage = {"prompt_tokens": 7, "total_tokens": 7}
        return {"object": "list", "model": body["model"], "data": data[::-1], "usage": usage}

    return answer


class Server:
    """Answers each request with the next of the answers, the last one again and again.

    Args:
        answers: each a body (a dict, bytes as they are, or a list of bytes that come one after the other, with
            pauses), or (status, headers, body), or a function of the request's body that gives one of these, or WAIT
            for none before the client has given up.
    """

    def __init__(self, answers):
        self.answers = answers
        self.requests = []
        self.headers = []
        self.release = threading.Event()  # lets go whoever was made to wait

    def answer(self, headers, body):
        self.headers.append(headers)
        self.requests.append(body)
        answer = self.answers[min(len(self.requests), len(self.answers)) - 1]
        if answer == WAIT:
            self.release.wait(20)
        answer = answer(body) if callable(answer) else answer
        return answer if isinstance(answer, tuple) else (200, {}, answer)


@contextmanager
def serving(*answers):
    """A running server and its base URL."""
    server = Server(answers)

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            assert self.path in {"/v1/chat/completions", "/v1/embeddings"}
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            status, headers, content = server.answer(
                {name.lower(): value for name, value in self.headers.items()}, body
            )
            chunks = content if isinstance(content, list) else [content]
            chunks = [chunk if isinstance(chunk, bytes) else json.dumps(chunk).encode() for chunk in chunks]
            length = str(sum(map(len, chunks)))
            try:
                self.send_response(status)
                for name, value in {"Content-Type": "application/json", "Content-Length": length, **headers}.items():
                    self.send_header(name, value)
                self.end_headers()
                for chunk in chunks:
                    self.wfile.write(chunk)
                    if len(chunks) > 1:
                        server.release.wait(0.02)
            except OSError:
                pass  # the client has given up

        def log_message(self, *_):
            pass

    http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=http.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    try:
        yield server, f"http://127.0.0.1:{http.server_port}/v1"
    finally:
        server.release.set()
        http.shutdown()
        http.server_close()
        thread.join()

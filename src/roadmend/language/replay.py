"""Recorded exchanges instead of a model."""

import threading
from collections import defaultdict, deque
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.language.chat import Reply, Request
from roadmend.language.errors import LanguageError, NotRecordedError
from roadmend.language.exchange import Exchange, load_exchanges

ENDING = ".exchanges.jsonl"


class ReplayModel:
    """Answers what was recorded, in the order of the recording, and nothing else.

    Args:
        source: a recording, or a folder with recordings.

    Raises:
        InputError: there is no recording, or one of them is broken.
    """

    def __init__(self, source: Path) -> None:
        files = sorted(source.glob(f"*{ENDING}")) if source.is_dir() else [source]
        if not files:
            raise InputError(str(source), f"holds no recording (*{ENDING})", "give the folder of an earlier run")
        self.left: dict[str, deque[Exchange]] = defaultdict(deque)
        self.lock = threading.Lock()
        for file in files:
            for exchange in load_exchanges(file):
                self.left[exchange.digest].append(exchange)

    def ask(self, request: Request) -> Reply:
        """Give the recorded answer.

        Raises:
            NotRecordedError: this was never asked, or not as often.
            LanguageError: the recorded exchange failed.
        """
        digest = request.digest()
        with self.lock:
            left = self.left.get(digest)
            exchange = left.popleft() if left else None
        if exchange is None:
            raise NotRecordedError(
                f"the recording has no (further) answer to this request for {request.purpose} ({digest[:12]}); "
                "it belongs to other reports, or to another version of the prompts"
            )
        if exchange.reply is None:
            raise LanguageError(exchange.error or "the recorded exchange failed")
        return exchange.reply

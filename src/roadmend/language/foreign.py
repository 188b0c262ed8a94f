"""A language model from outside, as those who ask have it."""

from typing import Any

from roadmend.core.foreign import blamed_on
from roadmend.core.source_digest import source_digest
from roadmend.language.chat import AnswerError, ChatModel, Reply, Request


class ForeignModel:
    """Passes requests on, and says in one line what went wrong."""

    def __init__(self, given: str, model: ChatModel) -> None:
        self.model = model
        own = getattr(model, "identity", "")
        self.identity = f"{given} {source_digest([type(model).__module__])} {own}".strip()
        """What tells it from another model."""
        self._where = f"backend {given}"

    def ask(self, request: Request) -> Reply:
        """Answer one request.

        Raises:
            AnswerError: its answer is no Reply.
            LanguageError: there is no usable answer.
            ForeignError: it fails.
        """
        with blamed_on(self._where, f"ask for {request.purpose}"):
            reply: Any = self.model.ask(request)
        if not isinstance(reply, Reply):
            raise AnswerError(f"{self._where} answered with {type(reply).__name__}, not a roadmend.language.chat.Reply")
        return reply

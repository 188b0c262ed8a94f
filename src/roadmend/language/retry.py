"""Asking again, with what was wrong, until an answer is accepted; within a bound."""

from collections.abc import Callable, Sequence
from typing import TypeVar

from roadmend.language.chat import ChatModel, Message, Request, Role
from roadmend.language.errors import AnswerError

Answer = TypeVar("Answer")


def ask_until_accepted(
    model: ChatModel,
    what: str,
    ask: Callable[[Sequence[str]], Request],
    judge: Callable[[Request, str], tuple[Answer, Sequence[str]]],
    attempts: int,
) -> Answer:
    """The first answer to which there is no objection.

    Args:
        model: that is asked.
        what: is asked for, for the error.
        ask: the request, given the objections to the answer before.
        judge: what the text of an answer says and the objections to it; may raise AnswerError, which is one.
        attempts: answers at most.

    Raises:
        AnswerError: as many answers were rejected.
        LanguageError: there was no answer.
    """
    objections: Sequence[str] = ()
    for _ in range(attempts):
        request = ask(objections)
        try:
            answer, objections = judge(request, model.ask(request).text)
        except AnswerError as error:
            objections = [str(error)]
            continue
        if not objections:
            return answer
    raise AnswerError(f"{attempts} answers for {what} were rejected, the last one because: {'; '.join(objections)}")


def objecting(objections: Sequence[str]) -> tuple[Message, ...]:
    """What is said after an answer was rejected; nothing if none was."""
    if not objections:
        return ()
    listed = "\n".join(f"- {objection}" for objection in objections)
    return (Message(Role.USER, (f"An earlier answer to this was rejected. Look again and mend:\n{listed}",)),)

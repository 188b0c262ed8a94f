"""What can go wrong with a language model."""

from roadmend.core.errors import RoadmendError


class LanguageError(RoadmendError):
    """A language model gave no usable answer."""


class RefusalError(LanguageError):
    """The model, or a filter in front of it, declined to answer."""


class UnavailableError(LanguageError):
    """The endpoint did not answer, or answered with an error, as often as it was tried."""


class AnswerError(LanguageError):
    """The answer is cut off or is not what was asked for."""


class NotRecordedError(LanguageError):
    """A replay was asked something that its recording does not hold."""

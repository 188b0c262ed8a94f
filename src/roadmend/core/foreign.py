"""Classes from outside: what is looked at before one is used, how it is made, and what is said when it fails."""

import inspect
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, get_args, get_type_hints

import numpy as np

from roadmend.core.errors import ForeignError, InputError, RoadmendError
from roadmend.core.parameters import NoParameters, Parameters
from roadmend.core.plain_moment import PlainMoment, plain_moment

_SEEN = set[type]()  # classes of which a first instance was tried out
_PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True, slots=True)
class ForeignClass:
    """A class that has what a Protocol asks for, and whose constructor takes what there is to give."""

    where: str  # noun and name, for people
    kind: type
    protocol: type
    parameters: type[Parameters]  # by the annotation of the constructor's argument of that name
    takes: tuple[str, ...]  # arguments that are given to its constructor, by name

    @classmethod
    def check(cls, where: str, thing: Any, protocol: type, offers: Sequence[str]) -> Self:
        """Look at a class.

        Args:
            where: noun and name, for people.
            thing: what should be a class.
            protocol: what it should have.
            offers: names of the arguments that its constructor may take.

        Raises:
            InputError: it is no class, lacks a method, or its constructor wants something else.
        """
        if not isinstance(thing, type):
            raise InputError(where, f"is no class but {_indefinite(type(thing).__name__)}", f"see {_home(protocol)}")
        _check_methods(where, thing, protocol)
        known = _constructor(where, thing)
        for name, argument in known.items():
            if argument.default is argument.empty and name not in offers:
                what = f"its constructor wants {name!r}, which nobody gives"
                raise InputError(
                    where, what, f"give it a default; there is to be had: {', '.join(offers) or 'nothing'}"
                )
        takes = tuple(name for name in offers if name in known)
        return cls(where, thing, protocol, _parameters(where, thing) if "parameters" in takes else NoParameters, takes)

    def is_new(self) -> bool:
        """Whether this was not asked of the class before, in this process."""
        is_new = self.kind not in _SEEN
        _SEEN.add(self.kind)
        return is_new

    def make(self, **offered: Any) -> Any:
        """An instance; of what is offered it gets what its constructor takes.

        Raises:
            InputError: it fails, or the instance lacks an attribute.
        """
        try:
            made = self.kind(**{name: offered[name] for name in self.takes})
        except RoadmendError:
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, it is said in one line
            raise InputError(self.where, f"cannot be made: {trouble_of(error)}", "mend the class") from None
        _check_attributes(self.where, made, self.protocol)
        return made


def check_object(where: str, thing: Any, protocol: type) -> None:
    """Look at an object that somebody has made, as ``ForeignClass`` does at a class and at what it makes of it.

    Args:
        where: noun and name, for people.
        thing: the object.
        protocol: what it should have.

    Raises:
        InputError: it lacks a method or an attribute.
    """
    _check_methods(where, type(thing), protocol)
    _check_attributes(where, thing, protocol)


@contextmanager
def blamed_on(where: str, doing: str = "") -> Iterator[None]:
    """While code from outside runs: what it raises becomes one line.

    Args:
        where: noun and name, for people.
        doing: what it was asked for, where that is not said yet.

    Raises:
        ForeignError: something that is no error of ours was raised.
    """
    try:
        yield
    except RoadmendError:
        raise
    except Exception as error:
        what = f"failed in {doing}: {trouble_of(error)}" if doing else trouble_of(error)
        raise ForeignError(where, what, "mend the class") from error


def check_answers(where: str, ask: Callable[[PlainMoment], object]) -> None:
    """Ask an instance that nothing is driven with about a plain moment, so that one without an answer is never started.

    Args:
        where: noun and name, for people.
        ask: does that; raises ForeignError where there is none.

    Raises:
        InputError: it has no answer.
    """
    try:
        ask(plain_moment())
    except ForeignError as error:
        raise InputError(where, f"cannot answer a plain scene: {error.what}", error.mend) from None


def number_of(given: Any) -> float:
    """A number that code from outside has given, as a plain one: an array of one, as a model gives it, will do.

    Raises:
        TypeError: it is no number.
    """
    if isinstance(given, float):
        return given
    try:
        number = np.asarray(given)
        if number.shape in {(), (1,)} and number.dtype.kind in "biufO":  # what a model gives for one scene
            return float(number.item())
    except (TypeError, ValueError, OverflowError, RuntimeError):
        pass
    raise TypeError(f"{type(given).__name__} is no number")


def is_text(given: Any) -> bool:
    """Whether a message can hold it: half of a surrogate pair, as in the name of a file that is no text, is none."""
    try:
        given.encode()
    except (AttributeError, UnicodeEncodeError):
        return False
    return isinstance(given, str)


def trouble_of(error: BaseException) -> str:
    """An error in one line, with the last place in the user's own code that it came through, if it did."""
    text = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_theirs(frame.filename)]
    return f"{text} ({frames[-1].filename} line {frames[-1].lineno})" if frames else text


def _is_theirs(file: str) -> bool:
    path = Path(file)
    libraries = (_PACKAGE, Path(sys.base_prefix), Path(sys.prefix))
    return path.is_absolute() and not any(path.is_relative_to(folder) for folder in libraries)


def _check_methods(where: str, thing: type, protocol: type) -> None:
    for name, method in vars(protocol).items():
        if not name.startswith("_") and callable(method):
            _check_method(where, thing, name, method, protocol)


def _check_attributes(where: str, made: Any, protocol: type) -> None:
    for name in protocol.__annotations__:
        if not isinstance(getattr(made, name, None), str):
            raise InputError(where, f"has no attribute {name!r} that is a text", f"see {_home(protocol)}")


def _check_method(where: str, thing: type, name: str, method: Any, protocol: type) -> None:
    arguments = [*inspect.signature(method).parameters][1:]
    wanted = f"{name}({', '.join(arguments)})"
    found = inspect.getattr_static(thing, name, None)
    if not callable(getattr(thing, name, None)):
        raise InputError(where, f"has no method {wanted}", f"add it, see {_home(protocol)}")
    own = [None] * (len(arguments) + (not isinstance(found, staticmethod | classmethod)))
    try:
        inspect.signature(getattr(thing, name)).bind(*own)
    except TypeError:
        raise InputError(where, f"its method {name} cannot be called as {wanted}", f"see {_home(protocol)}") from None
    except ValueError:
        return  # of compiled code nothing can be told before


def _constructor(where: str, thing: type) -> dict[str, inspect.Parameter]:
    try:
        known = inspect.signature(thing).parameters
    except (TypeError, ValueError) as error:
        raise InputError(where, f"its constructor cannot be looked at ({error})", "write it in Python") from None
    several = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD, inspect.Parameter.POSITIONAL_ONLY)
    return {name: each for name, each in known.items() if each.kind not in several}


def _parameters(where: str, thing: type) -> type[Parameters]:
    mend = "annotate it with a class on roadmend.core.parameters.Parameters"
    try:
        hint = get_type_hints(thing.__init__).get("parameters")  # type: ignore[misc] # of a class that we only look at
    except Exception as error:  # noqa: BLE001 - an annotation may be any expression
        raise InputError(where, f"its constructor's annotations cannot be read ({trouble_of(error)})", mend) from None
    for kind in (hint, *get_args(hint)):
        if isinstance(kind, type) and issubclass(kind, Parameters):
            for name, field in kind.model_fields.items():
                if field.is_required():
                    raise InputError(where, f"its parameter {name!r} has no default", "give it one")
            return kind
    raise InputError(where, "its constructor's argument 'parameters' says not what can be set", mend)


def _home(protocol: type) -> str:
    return f"{protocol.__module__}.{protocol.__name__}"


def _indefinite(noun: str) -> str:
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"

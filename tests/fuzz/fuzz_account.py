"""What comes of giving files to one reader: how many, how long, how much memory, and what was no documented refusal."""

import hashlib
import os
import resource
import signal
import traceback
from pathlib import Path

from fuzz_readers import DOCUMENTED, READERS, place_of

TIME_MAX = 10.0  # [s] of the processor, a file
WAIT_MAX = 120  # [s] of the clock, a file: a reader may also wait for ever
MANY = 100_000  # files; a reader that reads none of so many is given nothing that reaches what it does
MEMORY_MAX = 512 << 10  # [KiB] by which the process may grow


class Account:
    """Gives files to a reader and keeps account; a file that takes too long ends the process."""

    def __init__(self, name: str, seconds: float, seed: bytes, folder: Path) -> None:
        """Begin with a file that the reader reads.

        Args:
            name: the reader's.
            seconds: [s] of the processor's time, its own and its ended children's, for how long.
            seed: the first file; what is imported and compiled for it is not a file's doing.
            folder: where files are put.
        """
        self._name, self._reader, self._seconds = name, READERS[name], seconds
        self._path = place_of(name, folder)
        self._path.write_bytes(seed)
        for limit in (signal.SIGPROF, signal.SIGALRM):
            signal.signal(limit, signal.SIG_DFL)  # whoever began this process may have a use of its own for them
        self._reader.read(self._path)
        self._before, self._begin = _memory(), _processor()
        self._count = self._accepted = 0
        self._slowest, self._faults = (0.0, ""), dict[str, str]()

    @property
    def is_over(self) -> bool:
        """Whether the time is up."""
        return _processor() - self._begin >= self._seconds

    def read(self, data: bytes) -> None:
        """Let the reader read a file."""
        self._path.unlink()
        self._path.write_bytes(data)
        start, digest = _processor(), hashlib.sha256(data).hexdigest()[:12]
        signal.setitimer(signal.ITIMER_PROF, TIME_MAX)
        signal.alarm(WAIT_MAX)
        try:
            self._reader.read(self._path)
            self._accepted += 1
        except DOCUMENTED as error:
            if "\n" in str(error):
                self._fault("a message of several lines", digest, data)
        except BaseException as error:  # noqa: BLE001 - any other is what is looked for
            place = traceback.extract_tb(error.__traceback__)[-1]
            self._fault(f"{type(error).__name__} at {place.name}:{place.lineno}", digest, data)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.alarm(0)
        self._slowest = max(self._slowest, (_processor() - start, digest))
        self._count += 1

    def _fault(self, what: str, digest: str, data: bytes) -> None:
        kept = Path.cwd() / f"fault-{self._name}-{digest}"
        if what not in self._faults:
            kept.write_bytes(data)
            self._faults[what] = kept.name

    def told(self) -> dict[str, object]:
        """All of it as plain values."""
        grown = _memory() - self._before
        faults = self._faults | ({"memory": f"{grown >> 10} MB"} if grown > MEMORY_MAX else {})
        if self._count >= MANY and not self._accepted:
            faults |= {"read nothing": f"of {self._count} files"}
        return {
            "files": self._count,
            "accepted": self._accepted,
            "per_second": round(self._count / (_processor() - self._begin)),
            "slowest_s": round(self._slowest[0], 3),
            "grown_mb": grown >> 10,
            "faults": faults,
        }


def _memory() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _processor() -> float:
    return sum(os.times()[:4])

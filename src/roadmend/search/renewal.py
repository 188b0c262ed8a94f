"""A corpus whose cases are driven again, for a simulator or a policy that has changed a little."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from roadmend import __version__
from roadmend.core.errors import InputError
from roadmend.search.persistence import PersistenceTeller
from roadmend.search.policy_model import policy_model
from roadmend.search.rerun import Rerunner, renewed
from roadmend.world.corpus import Corpus, sorted_cases


@dataclass(frozen=True, slots=True)
class Renewed:
    """What came of it."""

    corpus: Corpus
    moved: int  # cases with another trajectory
    lost: int  # cases that come to something else now, or to the same as another


def renew(
    corpus: Corpus,
    rerunner: Rerunner,
    teller: PersistenceTeller,
    futures: int,
    report: Callable[[str, int, int], None] = lambda _what, _done, _total: None,
) -> Renewed:
    """Drive all cases again; those that come to something else, or to the same as another, are left out.

    Args:
        corpus: as it was.
        rerunner: runs the cases.
        teller: tells how persistent the violations are now.
        futures: by which it does; 0: it does not.
        report: called as it goes on: what is done, how much of it, of how much.

    Raises:
        InputError: a journal cannot be written.
        SimulationError: a worker process died.
    """
    total, kept, moved = len(corpus.cases), [], 0
    known: set[str] = set()  # trajectories; what was apart may have become the same
    for done, (case, found) in enumerate(zip(corpus.cases, rerunner(corpus.cases), strict=True), 1):
        report("run again", done, total)
        now = renewed(case, found)
        if now is not None and now.digest not in known:
            known.add(now.digest)
            kept.append(now)
            moved += now.digest != case.digest
    told = []
    for done, share in enumerate(teller(kept, futures), 1):
        report("persistence", done, len(kept))
        told.append(share)
    cases = tuple(replace(case, persistence=share) for case, share in zip(kept, told, strict=True))
    lost = total - len(cases)
    again = replace(
        corpus,
        cases=cases,
        model=policy_model(corpus.policy),
        dropped=corpus.dropped + lost,
        version=__version__,
    )
    return Renewed(again, moved, lost)


def without_splits_of(corpus: Corpus, other: Corpus) -> Corpus:
    """A corpus without the splits that another one has, and without that one's episodes.

    Raises:
        InputError: they are of two policies.
    """
    if corpus.policy != other.policy:
        raise InputError("--with", f"is of the policy '{other.policy}'", f"give one of '{corpus.policy}'")
    splits = {case.split for case in other.cases}
    return replace(corpus, cases=tuple(case for case in corpus.cases if case.split not in splits))


def joined(corpus: Corpus, other: Corpus) -> Corpus:
    """Both corpora's cases; an episode that both have is the other's, and so is what both plans name."""
    known = {case.digest for case in other.cases}
    own = [case for case in corpus.cases if case.digest not in known]
    splits = {case.split for case in own}
    plan = {**other.plan, **{name: value for name, value in corpus.plan.items() if name in splits}}
    return replace(
        corpus,
        cases=sorted_cases([*own, *other.cases]),
        plan=plan,
        command=f"{other.command}; {', '.join(sorted(splits))} by {corpus.command}, renewed",
        dropped=corpus.dropped + other.dropped,
        fleeting=corpus.fleeting + other.fleeting,
    )

"""Which vehicles a report is about, and how it describes each."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from roadmend.safe.reading.body_class import BodyClass, Name, classify, find_names
from roadmend.safe.reading.text import Sentence, case_vehicle, name_case_vehicle

REFERENCE = re.compile(r"\bv(\d)\b")

_VERB = (
    r"(?<!non-)\b(?:was|is|were|had|has|which|who|that|driven|driving|travel(?:ing|ed)|being|operated|occupied|"
    r"parked|stopped|struck|while|approach\w*|head\w*|proceed\w*|enter\w*|turn\w*|failed|attempt\w*|drifted|lost|"
    r"came|collided|when|northbound|southbound|eastbound|westbound|impacted|contacted|hit|made|did|began|crossed|"
    r"went|ran|moving|slow\w*)\b"
)
_DESCRIBED_AFTER = re.compile(
    r"\bv(?P<number>\d)\b\)?(?:\s*\([^)]{0,60}\))*(?:\s*[,.:=-]+\s*(?:(?:was|is)\s+)?(?:also\s+)?(?:(?:an?|the|"
    r"another)\s+(?:(?:legally|illegally|parked|unoccupied|stopped|disabled)\s+)*)?\s*|\s+(?:was|is)\s+(?:also\s+)?(?:an?|the)\s+|\s*\(\s*(?:an?\s+|the\s+)?|"
    r"\s+an?\s+(?=(?:19|20)\d\d\b)|[\s,]+(?:(?:was|is|had been)\s+)?(?:operating|driving|drove|operated|drives|"
    r"in)\s+(?:an?|the|his|her)\s+)(?:(?:north|south|east|"
    rf"west)bound,?\s+)?(?P<text>(?:(?!{_VERB}|\bv\d\b)[^.;()]){{2,140}})"
)
_DESCRIBED_BEFORE = re.compile(
    r"\b(?:an?|the|another|\d{4})\s+(?P<text>(?:(?!\bv\d\b)[^;()]){2,100}?),?\s*\(\s*(?:the )?(?:(?:case|"
    r"subject) vehicle\W+)?v(?P<number>\d)\b"
)
_APPOSED = re.compile(  # "a 2010 Ford Focus, v1, struck"
    r"(?<!v\d, )(?<!v\d )\b(?:an?|the|another)\s+(?P<text>(?:(?!\b(?:v\d|an?|the|"
    r"another)\b)[^.;(),]){2,60}), v(?P<number>\d),"
)
_OWN_CAR = re.compile(
    r"\bv(?P<number>\d)\b(?:(?!\bv\d\b)[^.;]){0,120}?\bin (?:his|her|"
    rf"their) (?P<text>(?:(?!{_VERB})[\w -]){{3,40}})"
)
_LAST_DETERMINER = re.compile(r".*\b(?:an?|the|another|with|and|of|her|his|their|in|by|driving)\s+(?=\S)")
_WITH_A_TRAILER = re.compile(r"\bwith an? (?:[\w-]+ ){0,2}(?:semi-?)?trailer$")
_WHO = re.compile(
    r"\b(?:driver|passenger|occupant|male|female|man|woman|boy|girl|year[- ]old|side|front|rear|lane|road|curve)\b"
)
_NO_CONTACT = re.compile(
    r"\bv(\d)\b(?:\s*\([^)]*non-?contact[^)]*\)|[^.;]{0,40}\b(?:non-?contact vehicle|"
    r"(?:was|were) not (?:struck|contacted|hit|involved)|"
    r"did not (?:make contact|come (?:in|into) contact|contact|strike|collide)))"
)
_SUBJECT_NOUN = (
    r"(?:car|vehicle|automobile|sedan|coupe|hatchback|convertible|wagon|suv|sport utility vehicle|utility vehicle|"
    r"crossover|minivan|van|pickup truck|pickup|tractor[-/ ]?trailer|semi-?(?:truck|trailer truck)?|18[- ]wheeler|"
    r"box truck|dump truck|(?:delivery |cargo |commercial )?truck|bus|taxi|motorcycle)"
)
_INTRODUCED = re.compile(
    r"\b(?P<article>an?|the|another|his|her|driving an?|"
    rf"driver of an?)\s+(?P<text>(?:(?!\b(?:{_SUBJECT_NOUN[3:-1]})\b|"
    rf"\b(?:of|and|the|an?|to|in|on|by|at|with|from)\b)[\w/'-]+,?\s+){{0,6}}?{_SUBJECT_NOUN})(?![\w-])(?! (?:lane|"
    r"stop|door|seat|driver|occupant|accident|crash|collision|road|fuel|trailer|registration|damage|"
    r"ahead of (?:it|him|her)))"
)
_STRUCK_UNNUMBERED = re.compile(
    r"\b(?:struck|hit|strik(?:es|ing)|hitting|impact(?:ed|s)?(?: with)?|contacted|collided with|collision with|"
    r"crashed into|rear-ended|ran into|sideswiped)\s+(?:the\s+[\w\s-]{1,30}\s+of\s+)?(?P<np>(?:an?|another|"
    r"the)\s+(?P<kind>legally parked|parked|unoccupied|stopped|disabled|oncoming|second|other|"
    rf"non-occupied)\s+(?:(?:(?!v\d)[\w/-]+\s+){{0,5}}?{_SUBJECT_NOUN}|(?:19|20)\d\d [\w-]+ [\w-]+))(?! trailer)\b"
)


_MAKE = "make "


@dataclass(frozen=True, slots=True)
class Described:
    """A vehicle as the report describes it.

    Attributes:
        number: the report's, or the place in the order of mention where the report has no numbers.
        body: its class; None where nothing says so.
        name: make and model; None where nothing says so.
        sentence: where it is described, as the report puts it; None where it is not.
    """

    number: int
    body: BodyClass | None = None
    name: Name | None = None
    sentence: str | None = None


@dataclass(frozen=True, slots=True)
class Cast:
    """The vehicles and the report with their names put in.

    Attributes:
        vehicles: those in contact, by number.
        sentences: the report's; other names of a vehicle are replaced by its number.
        left_out: numbers of vehicles that touched nothing.
    """

    vehicles: tuple[Described, ...]
    sentences: tuple[Sentence, ...]
    left_out: tuple[int, ...]


def find_cast(sentences: Sequence[Sentence]) -> Cast:
    """Find the vehicles; there are none where the report names none."""
    case = case_vehicle(" ".join(sentence.plain for sentence in sentences))
    named = tuple(replace(sentence, plain=name_case_vehicle(sentence.plain, case)) for sentence in sentences)
    if not any(REFERENCE.search(sentence.plain) for sentence in named):
        named = _number_by_mention(named)
    elif not any(REFERENCE.search(sentence.plain) for sentence in sentences) and (
        own := _describe(named, [case], case)[case].name
    ):
        named = _number_by_mention(named, own)
    else:
        named = _number_the_struck(named)
    left_out = {int(match[1]) for sentence in named for match in _NO_CONTACT.finditer(sentence.plain)}
    numbers = sorted({int(match[1]) for sentence in named for match in REFERENCE.finditer(sentence.plain)})
    described = _describe(named, numbers, case)
    left_out &= {number for number in numbers if not _touches(named, number)}
    vehicles = tuple(described[number] for number in numbers if number not in left_out)
    return Cast(vehicles, _by_number(named, vehicles), tuple(sorted(left_out)))


def _touches(sentences: Sequence[Sentence], number: int) -> bool:
    contact = re.compile(
        rf"(?:front|rear|back|side|plane|bumper|corner)s? (?:\w+ )?of v{number}\b|"
        rf"(?:struck|hit|impacted|contacted) (?:the [\w\s-]{{1,30}} of )?v{number}\b"
    )
    return any(contact.search(sentence.plain) for sentence in sentences)


def _describe(sentences: Sequence[Sentence], numbers: Sequence[int], case: int) -> dict[int, Described]:
    found = {number: Described(number) for number in numbers}
    for sentence in sentences:
        for number, text in _descriptions(sentence.plain):
            found[number] = _better(found[number], text, sentence.text)
    for sentence in sentences[:4]:  # the opening names the case vehicle before it gives it a number
        opening = re.search(r"\b(?:an?|the)\s+((?:19|20)\d\d\s+(?:(?!\b(?:an?|the)\b)[^.;()]){4,80})", sentence.plain)
        if opening and case in found and found[case].body is None and not REFERENCE.search(sentence.plain):
            names = [described.name for described in found.values() if described.name]
            if not any(
                (name.make, name.model) == (own.make, own.model) for name in find_names(opening[1])[:1] for own in names
            ):
                found[case] = _better(found[case], re.split(_VERB, opening[1])[0], sentence.text)
    return found


def _descriptions(plain: str) -> list[tuple[int, str]]:
    after = [(int(match["number"]), match["text"]) for match in _DESCRIBED_AFTER.finditer(plain)]
    before = []
    for match in _DESCRIBED_BEFORE.finditer(plain):
        text = _LAST_DETERMINER.sub("", _WITH_A_TRAILER.sub("", match["text"]).rstrip())
        before.append((int(match["number"]), text))
    before += [(int(match["number"]), match["text"]) for match in _APPOSED.finditer(plain)]
    own = [(int(match["number"]), match["text"]) for match in _OWN_CAR.finditer(plain) if find_names(match["text"])]
    return [(number, text) for number, text in (*before, *after, *own) if not _is_of_people(text)]


def _is_of_people(text: str) -> bool:
    names = find_names(text)
    return bool(_WHO.search(text[: names[0].span[0]] if names else text))


def _better(described: Described, text: str, sentence: str) -> Described:
    body, names = classify(text), find_names(text)
    if body is None:
        return described
    if described.body is not None and described.body.confidence >= body.confidence:
        return described if described.name or not names else replace(described, name=names[0])
    return replace(described, body=body, name=names[0] if names else described.name, sentence=sentence)


def _by_number(sentences: Sequence[Sentence], vehicles: Sequence[Described]) -> tuple[Sentence, ...]:
    """Put numbers where the report calls a vehicle by its make, model or body."""
    aliases: dict[str, int] = {}
    for described in vehicles:
        for alias in _aliases(described):
            aliases[alias] = 0 if alias in aliases else described.number  # 0: of two vehicles, so of none
    usable = sorted((alias for alias, number in aliases.items() if number), key=len, reverse=True)
    if not usable:
        return tuple(sentences)
    pattern = re.compile(
        rf"\b(?:the|this) (?:\d{{4}} )?({'|'.join(map(re.escape, usable))})(?![\w-])"
        r"(?!\s*(?:\w+\s*)?,?\s*\(\s*v\d|'s? (?:driver|owner))(?: \(\s*v\d\s*\))?"
    )
    return tuple(
        replace(sentence, plain=pattern.sub(lambda match: f"v{aliases[match[1]]}", sentence.plain))
        for sentence in sentences
    )


def _aliases(described: Described) -> set[str]:
    aliases = set()
    if described.name is not None:
        aliases = {described.name.make, described.name.model, f"{described.name.make} {described.name.model}".strip()}
    if described.body is not None and described.body.basis.startswith("the words"):
        aliases.add(described.body.basis.removeprefix("the words '").removesuffix("'"))
        if described.body.model is not None:
            aliases.add({"Semi Truck": "semi"}.get(described.body.model, described.body.model.lower()))
    return {alias for alias in aliases if len(alias) > 1 and alias not in {"car", "4-door", "2-door"}}


def _number_the_struck(sentences: Sequence[Sentence]) -> tuple[Sentence, ...]:
    """Give a number to a vehicle that is struck and has none, as parked ones often have."""
    whole = " ".join(sentence.plain for sentence in sentences)
    number = max(int(match[1]) for match in REFERENCE.finditer(whole)) + 1
    if number > 2 or re.search(r"\bsingle[- ](?:motor )?vehicle\b", whole):
        return tuple(sentences)
    for sentence in sentences:
        match = _STRUCK_UNNUMBERED.search(sentence.plain)
        if match and REFERENCE.search(sentence.plain[: match.start()]):
            mention, kind = match["np"], match["kind"]
            noun = mention.split()[-1]
            return tuple(
                replace(
                    each,
                    plain=re.sub(
                        rf"\b(?:the|an?) {re.escape(kind)} {noun}\b",
                        f"v{number}",
                        each.plain.replace(mention, f"v{number}, {mention},"),
                    ),
                )
                if each is sentence
                else replace(each, plain=re.sub(rf"\bthe {re.escape(kind)} {noun}\b", f"v{number}", each.plain))
                for each in sentences
            )
    return tuple(sentences)


def _number_by_mention(sentences: Sequence[Sentence], first: Name | None = None) -> tuple[Sentence, ...]:
    """Number the vehicles of a report without numbers in the order in which it mentions them.

    Args:
        sentences: the report's.
        first: what the first one is called, where the report calls it the case vehicle too.
    """
    keys = [_key_of(first)] if first else []
    result = []
    for sentence in sentences:
        plain, place = "", 0
        for start, end, key, is_new in _mentions(sentence.plain):
            number = _find(keys, key, is_new=is_new)
            if number is None:
                continue
            plain += f"{sentence.plain[place:start]}v{number} ({sentence.plain[start:end]}) "
            place = end
        result.append(replace(sentence, plain=" ".join((plain + sentence.plain[place:]).split())))
    return tuple(result)


def _key_of(name: Name) -> tuple[str, ...]:
    return tuple(filter(None, (f"{_MAKE}{name.make}", name.model)))


def _find(keys: list[tuple[str, ...]], key: tuple[str, ...], *, is_new: bool) -> int | None:
    # Two vehicles may be of one make: it tells them apart only where there is nothing else.
    own = {part for part in key if not part.startswith(_MAKE)} or {*key}
    for number, known in enumerate(keys, start=1):
        if own & {*known}:
            keys[number - 1] = (*known, *key)
            return number
    if not is_new or len(keys) == 9:
        return None
    keys.append(key)
    return len(keys)


def _mentions(plain: str) -> list[tuple[int, int, tuple[str, ...], bool]]:
    """Places in a sentence that speak of a vehicle: start, end, what identifies it, whether it may be a new one."""
    places: list[tuple[int, int, tuple[str, ...], bool]] = []
    for name in find_names(plain):
        before = re.search(
            r"\b(?:an?|the|another|his|her)\s+(?:(?!(?:an?|the)\b)[\w'-]+,?\s+){0,4}$", plain[: name.span[0]]
        )
        year = re.search(r"\b(?:19|20)\d\d\s+(?:[\w'-]+\s+){0,2}$", plain[: name.span[0]])
        if before is None and year is None:
            continue
        start = before.start() if before else year.start() if year else name.span[0]
        body = re.match(rf"(?:[\s,]+[\w'/-]+){{0,4}}?[\s,]+{_SUBJECT_NOUN}(?![\w-])", plain[name.span[1] :])
        end = name.span[1] + (body.end() if body and not re.search(_VERB, body[0]) else 0)
        key = (*_key_of(name), *([_noun(plain[start:end])] if body else []))
        places.append((start, end, tuple(filter(None, key)), True))
    for match in _INTRODUCED.finditer(plain):
        if any(start < match.end() and match.start() < end for start, end, _, _ in places):
            continue
        noun = _noun(match["text"])
        if noun and noun not in {"car", "vehicle", "automobile"}:
            places.append(
                (match.start(), match.end(), (noun,), match["article"] != "the" or noun not in plain[: match.start()])
            )
    return sorted(places)


def _noun(text: str) -> str:
    match = re.search(rf"{_SUBJECT_NOUN}$", text)
    return match[0].replace("pickup truck", "pickup") if match else ""

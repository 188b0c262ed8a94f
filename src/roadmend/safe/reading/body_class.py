"""Body class of a vehicle, from the words that describe it."""

import functools
import importlib.resources
import re
from dataclasses import dataclass

from roadmend.core.yaml_file import parse_yaml
from roadmend.safe.dsl import DslModel

_FILE = "vehicle_models.yaml"

_MAKE_ALIASES = {
    "chevy": "chevrolet",
    "mercedes benz": "mercedes-benz",
    "mercedes": "mercedes-benz",
    "vw": "volkswagen",
    "mini-cooper": "mini",
    "landrover": "land rover",
    "toyota/scion": "scion",
    "rolls royce": "rolls-royce",
    "olds": "oldsmobile",
    "caddy": "cadillac",
    "harley-davidson": "harley-davidson",
    "infinity": "infiniti",
    "hundai": "hyundai",
    "hyundia": "hyundai",
    "mitsubshi": "mitsubishi",
    "volkswagon": "volkswagen",
    "freighliner": "freightliner",
    "chevorlet": "chevrolet",
    "chrystler": "chrysler",
}

# In the order in which they win; the confidence is that of the class where these words are all there is.
_BODY_WORDS: tuple[tuple[DslModel, float, str], ...] = (
    (
        DslModel.SEMI_TRUCK,
        0.95,
        (
            r"(?<!farm )tractor(?! mower)|semi(?!-?automatic)(?:-?\s?(?:truck|trailer))?s?|18[- ]wheel(?:er)?|big rig|"
            r"articulated (?:truck|lorry)|truck[- ]trailer|class 8 truck|bobtail"
        ),
    ),
    (
        DslModel.MINIVAN,
        0.95,
        (
            r"minivan|(?<!\w)(?:cargo|conversion|passenger|delivery|full[- ]?size|work|panel|step|utility)[- ]?van|van|"
            r"people[- ](?:carrier|mover)|mpv"
        ),
    ),
    (
        DslModel.PICKUP,
        0.95,
        r"pickup(?: ?truck)?|(?:crew|extended|quad|king|super|regular|double|access)[- ]?cab|light truck",
    ),
    (
        DslModel.SUV,
        0.95,
        (
            r"sports?[- ]?utility(?: vehicle)?|suvs?|s\.u\.v\.|crossover|"
            r"(?:compact|large|mid[- ]?size|full[- ]?size|small|4-door|2-door|4[- ]wheel[- ]drive|"
            r"4x4,?)? ?utility(?! (?:trailer|pole|van|truck|line|box|room|company|work))(?: vehicle)?|cuv"
        ),
    ),
    (
        DslModel.SEDAN,
        0.95,
        (
            r"sedan|saloon|coupe|hatch-?back|convertible|cabriolet|estate car|roadster|(?:station )?wagon|fastback|"
            r"lift-?back|limousine|sports? car|passenger car|hard-?top|spyder"
        ),
    ),
    (
        DslModel.SEMI_TRUCK,
        0.5,
        (
            r"(?:medium|heavy|heavy[- ]duty|medium[- ]duty|medium/heavy|large|commercial|box|cargo|dump|straight|"
            r"flat-?bed|delivery|tow|garbage|refuse|cement|concrete|mixer|tanker|fire|military|army|moving|log(?:ging)?|"
            r"stake|bucket|utility|single[- ]unit|stake[- ]?bed|u-haul)[- ](?:\w+ )?truck|fire engine|"
            r"(?:school |transit |city |tour |shuttle )?bus|motor ?home|motor ?coach|recreational vehicle|lorry|"
            r"truck-tractor"
        ),
    ),
    (DslModel.SEDAN, 0.6, r"(?:sub-?)?compact(?:-size[d]?)?(?: car)?|police car|taxi(?:cab)?|(?:2|3|4|5)[- ]door|car"),
)
_NO_CLASS = re.compile(
    r"\b(motorcycle|motor ?bike|motor ?scooter|moped|bicycle|farm tractor|atv|all[- ]terrain vehicle|snowmobile|"
    r"train|trolley|golf cart|go-?kart|tram)\b"
)
_TRAILED = re.compile(r"\b(pulling|towing|hauling|with an? (?:\w+ )?trailer)\b")
_HEAVY_LOAD = re.compile(r"\b(?:semi-?\s?trailer|trailers?)\b")
_COMPILED = tuple(
    (model, confidence, re.compile(rf"(?<![\w-])(?:{pattern})(?!\w|-(?!size|trailer))"))
    for model, confidence, pattern in _BODY_WORDS
)
_BARE_TRUCK = re.compile(r"\btruck\b")


@dataclass(frozen=True, slots=True)
class BodyClass:
    """What a description says about the body.

    Attributes:
        model: the class; None where the language has none for such a vehicle.
        confidence: from 0 to 1.
        basis: what it rests on.
    """

    model: DslModel | None
    confidence: float
    basis: str


@dataclass(frozen=True, slots=True)
class Name:
    """Make and model as a description names them, in lower case.

    Attributes:
        make: as in the table.
        model: as in the table; empty where none of the table's is named.
        span: place of both in the description.
    """

    make: str
    model: str
    span: tuple[int, int]


@functools.cache
def _table() -> dict[str, dict[str, DslModel]]:
    content = importlib.resources.files(__package__).joinpath(_FILE).read_text(encoding="utf-8")
    return {
        make: {str(name): DslModel(body) for body, names in bodies.items() if body != "any" for name in names}
        | ({"": DslModel(bodies["any"])} if "any" in bodies else {})
        for make, bodies in parse_yaml(content, _FILE).items()
    }


@functools.cache
def _makes() -> re.Pattern[str]:
    names = sorted({*_table(), *_MAKE_ALIASES}, key=len, reverse=True)
    return re.compile(rf"(?<![\w-])({'|'.join(re.escape(name) for name in names)})(?![\w-])")


@functools.cache
def _models(make: str) -> re.Pattern[str]:
    names = sorted((name for name in _table().get(make, {}) if name), key=len, reverse=True)
    # "cr-v", "cr v" and "crv" are one model, and so are "f-150" and "f150"
    spelled = (re.escape(name).replace(r"\-", "[- ]?").replace(r"\ ", "[- ]") for name in names)
    # A figure before "-door" or a year is none of the models that are called by a figure.
    return re.compile(rf"(?<![\w-])({'|'.join(spelled) or '(?!)'})(?![\w]|[- ](?:door|speed|cylinder|axle|wheel)|-\d)")


def find_names(text: str) -> tuple[Name, ...]:
    """The makes, each with its model, that a text in plain form names."""
    names = []
    for match in _makes().finditer(text):
        make = _MAKE_ALIASES.get(match[1], match[1])
        tail = re.match(r"(?:[^.;()]|\.(?=\w)){0,40}", text[match.end() :])
        model = _models(make).search(tail[0] if tail else "")
        if model is None:
            names.append(Name(make, "", match.span()))
        else:
            names.append(Name(make, _listed(make, model[1]), (match.start(), match.end() + model.end())))
    return tuple(names)


def _listed(make: str, spelled: str) -> str:
    squeezed = re.sub(r"[- ]", "", spelled)
    return next(name for name in _table()[make] if name and re.sub(r"[- ]", "", name) == squeezed)


def classify(description: str) -> BodyClass | None:
    """The body class that a description in plain form gives; None if it gives none."""
    trailed = _TRAILED.search(description)
    own = description[: trailed.start()] if trailed else description
    names = find_names(own)
    for model, confidence, words in _COMPILED:
        found = words.search(own)
        if found is None or (confidence < 0.9 and _by_name(names) is not None):
            continue
        return BodyClass(model, confidence, f"the words '{found[0].strip()}'")
    none = _NO_CLASS.search(own)
    if none:
        return BodyClass(None, 1.0, f"the language has no class for a {none[1]}")
    if (by_name := _by_name(names)) is not None:
        return by_name
    if _BARE_TRUCK.search(own):
        if trailed and _HEAVY_LOAD.search(description, trailed.start()):
            return BodyClass(DslModel.SEMI_TRUCK, 0.5, "the word 'truck' and its trailer")
        return BodyClass(DslModel.PICKUP, 0.4, "the word 'truck' alone")
    return None


def _by_name(names: tuple[Name, ...]) -> BodyClass | None:
    for name in names:
        models = _table().get(name.make, {})
        if name.model:
            return BodyClass(models[name.model], 0.85, f"the table of models: {name.make} {name.model}")
        if "" in models:
            return BodyClass(models[""], 0.6, f"the table of makes: {name.make}")
    return None

"""Crash texts made from drawn scenes, for the network to begin with: how directions are told, and what follows from what.

Nothing here comes from the rules of the reader. A scene is drawn first (two headings, two turns, a road, a contact), then
each of its facts is told in one of many ways, so that text and key agree by construction.
"""

import importlib.resources
import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import yaml

from roadmend.safe.dsl import KM_PER_MILE, Action, RoadType, Side, Time, Weather
from roadmend.safe.trained.lessons import CrashLesson, lesson_of
from roadmend.safe.trained.marked_text import Name, NamedCrash
from roadmend.safe.trained.outputs import HEADINGS, STEMS

_POINTS = ("north", "east", "south", "west")
_TURN = {Action.MOVE_FORWARD: 0, Action.TURN_LEFT: 3, Action.TURN_RIGHT: 1}  # [quarter turns, clockwise]
_HAND = {Action.TURN_LEFT: "left", Action.TURN_RIGHT: "right"}
_SAME, _FROM_LEFT, _OPPOSITE, _FROM_RIGHT = range(4)  # quarter turns from the first heading to the second
_BESIDE = {_SAME: "same", _FROM_LEFT: "left", _OPPOSITE: "opposite", _FROM_RIGHT: "right"}
_KINDS = {  # of crash, by how often
    "cross": 6,
    "out_of_the_stem": 5,
    "left_turn": 5,
    "behind": 5,
    "oncoming": 5,
    "side_by_side": 2,
    "merge": 2,
}
_STRAIGHT, _CURVE, _MERGING = (RoadType.STRAIGHT,), (RoadType.CURVE,), (RoadType.MERGING,)
_CROSS, _TEE = (RoadType.INTERSECTION,), (RoadType.T_INTERSECTION,)
_ROADS: Mapping[str, Sequence[RoadType]] = {  # where each kind happens
    "cross": _CROSS,
    "out_of_the_stem": _TEE,
    "left_turn": _CROSS * 2 + _TEE + _STRAIGHT,
    "behind": _STRAIGHT * 3 + _CURVE + _CROSS + _TEE,
    "oncoming": _STRAIGHT + _CURVE,
    "side_by_side": _STRAIGHT * 2 + _CURVE,
    "merge": _MERGING,
}
_TELLS = 0.5  # of each of light, weather and limits, how often it is told
_LIMITS: Mapping[str, Sequence[int]] = {"mph": range(20, 75, 5), "kmh": range(30, 140, 10)}  # that are posted
_MARK = re.compile("\x01([01])([^\x02]*)\x02")  # around the names of vehicles until the text is whole


@dataclass(frozen=True, slots=True)
class _MadeUpCrash:
    """Two vehicles that meet; headings and the stem in quarter turns clockwise from north; of light, weather and limit those that are told."""

    kind: str
    road: RoadType
    headings: tuple[int, int]
    actions: tuple[Action, Action]
    stem: int | None
    lanes: int
    light: str | None
    weather: str | None
    limit: int | None  # on the first vehicle's road, as it is posted
    unit: str  # of the limit, "mph" or "kmh"


def made_up_lesson(generator: random.Random) -> CrashLesson:
    """Draw a scene and tell it."""
    scene = _draw(generator)
    return _Teller(scene, generator).lesson()


def _draw(generator: random.Random) -> _MadeUpCrash:
    kind = generator.choices([*_KINDS], [*_KINDS.values()])[0]
    road = generator.choice(_ROADS[kind])
    relation = {"left_turn": _OPPOSITE, "oncoming": _OPPOSITE}.get(kind, _SAME)
    if kind in ("cross", "out_of_the_stem"):
        relation = generator.choice([_FROM_LEFT, _FROM_RIGHT])
    first = generator.randrange(4)
    actions = [Action.MOVE_FORWARD, Action.MOVE_FORWARD]
    if kind == "cross":
        actions = generator.choices([*Action], [6, 1, 1], k=2)
    elif kind == "out_of_the_stem":
        actions[0] = generator.choice([Action.TURN_LEFT, Action.TURN_RIGHT])
    elif kind == "left_turn":
        actions[0] = Action.TURN_LEFT
    stem = None
    if road is RoadType.T_INTERSECTION:
        aside = {"out_of_the_stem": 2, "left_turn": 3}.get(kind, generator.choice([1, 3]))
        stem = (first + aside) % 4
    lanes = generator.choice([2, 2, 2, 3, 4, 4, 5, 6])
    weather = generator.choice([*Weather]) if generator.random() < _TELLS else None
    light = generator.choice([*Time]) if generator.random() < _TELLS else None
    if weather is Weather.SUNNY:
        light = Time.DAYTIME
    unit = generator.choices([*_LIMITS], [7, 3])[0]
    limit = generator.choice(_LIMITS[unit]) if kind != "merge" and generator.random() < _TELLS else None
    return _MadeUpCrash(
        kind,
        road,
        (first, (first + relation) % 4),
        (actions[0], actions[1]),
        stem,
        lanes,
        light,
        weather,
        limit,
        unit,
    )


@dataclass(slots=True)
class _Teller:
    """Tells one scene."""

    scene: _MadeUpCrash
    generator: random.Random
    names: list[Mapping[str, Sequence[str]]] = field(default_factory=list)
    introduced: set[int] = field(default_factory=set)
    streets: Sequence[str] = ()
    landmark: str = ""
    contact: Mapping[str, Any] = field(default_factory=dict)

    def lesson(self) -> CrashLesson:
        """The text with its key."""
        scene, draw = self.scene, self.generator
        self.names = self._named()
        self.streets = draw.sample(_phrases()["streets"], 3)
        self.landmark = draw.choice(_phrases()["landmarks"])
        tells_place = scene.road in (RoadType.CURVE, RoadType.MERGING) or draw.random() < 0.8
        tells_lanes = draw.random() < 0.6
        parts = self._ways()
        if tells_place:
            parts.insert(draw.choice([0, len(parts)]), self._say("place", scene.road.value))
        if tells_lanes:
            parts.insert(draw.randrange(len(parts) + 1), self._say("lanes", scene.lanes))
        parts += [*self._deeds(), self._struck()]
        for about in self._surroundings():
            parts.insert(draw.choice([0, len(parts), draw.randrange(len(parts) + 1)]), about)
        for _ in range(draw.randrange(4)):
            parts.insert(draw.randrange(len(parts) + 1), draw.choice(_phrases()["beside_the_point"]))
        text = " ".join(parts)
        change = draw.random()
        text = text.lower() if change < 0.15 else text.upper() if change < 0.2 else text
        crash, order = _unmarked(text)
        return lesson_of(crash, self._key(order, tells_place=tells_place, tells_lanes=tells_lanes))

    def _named(self) -> list[Mapping[str, Sequence[str]]]:
        """What each vehicle is called: at first, as subject, as object, as owner."""
        draw, phrases = self.generator, _phrases()
        bodies, colours = draw.sample(phrases["bodies"], 2), draw.sample(phrases["colours"], 2)
        style = draw.choice(["own", "numbers", "letters", "surnames", "roles", "bodies"])
        if style == "own":
            me, other = draw.sample(range(2), 2)
            body = bodies[other]
            found = [*range(2)]
            mine = {
                "first": [f"my {bodies[me]}", "I"],
                "subject": ["I"],
                "object": ["me", f"my {bodies[me]}"],
                "owner": ["my"],
            }
            theirs = {
                "first": [f"a {colours[0]} {body}", f"a {body}", f"some {body}"],
                "subject": [f"the {body}", "the other driver", "he", "she", "the other car"],
                "object": [f"the {body}", "the other car", "it", "him"],
                "owner": ["his", f"the {body}'s"],
            }
            return [mine if at == me else theirs for at in found]
        words = [f"the {body}" for body in bodies]
        if style in ("numbers", "letters"):
            pattern = draw.choice(phrases[style])
            words = [pattern.format(n=n) for n in (("A", "B") if style == "letters" else (1, 2))]
        elif style != "bodies":
            words = draw.sample(phrases[style], 2)
        rows = zip(words, bodies, colours, strict=True)
        return [_spoken(word, body, colour, is_body=style == "bodies") for word, body, colour in rows]

    def _name(self, vehicle: int, form: str) -> str:
        if vehicle not in self.introduced and form == "subject":
            form = "first"
        self.introduced.add(vehicle)
        return f"\x01{vehicle}{self.generator.choice(self.names[vehicle][form])}\x02"

    def _say(self, *path: Any, a: int = 0, **more: str) -> str:
        """A phrase of the tables about a vehicle and the other one."""
        phrase = _phrases()
        for step in path:
            phrase = phrase[step]
        text = self.generator.choice(phrase)
        scene, b = self.scene, 1 - a
        heading = scene.headings[a]
        crosses = scene.headings[0] % 2 != scene.headings[1] % 2
        stem = scene.stem if scene.stem is not None else 0
        axis = [_POINTS[heading], _POINTS[(heading + 2) % 4]]
        self.generator.shuffle(axis)
        main = 1 if scene.kind == "out_of_the_stem" else 0
        values = {
            "go": self.generator.choice(_phrases()["going"]),
            "street": self.streets[a if crosses else 0],
            "other": self.streets[2],
            "main": self.streets[main],
            "side": self.streets[1 - main],
            "landmark": self.landmark,
            "stem": _POINTS[stem],
            "axis": self.generator.choice(["{}-{}", "{} and {}", "{} to {}"]).format(*axis),
            "d": _POINTS[heading],
            "D": _POINTS[heading][0].upper(),
            "back": _POINTS[(heading + 2) % 4],
            "left": _POINTS[(heading + 3) % 4],
            "right": _POINTS[(heading + 1) % 4],
            "hand": _HAND.get(scene.actions[a], ""),
            **more,
        }
        values["way"] = self.generator.choice(_phrases()["ways"]).format(**values)
        for word, vehicle, form in (
            ("a", a, "subject"),
            ("b", b, "subject"),
            ("ao", a, "object"),
            ("bo", b, "object"),
            ("ap", a, "owner"),
            ("bp", b, "owner"),
        ):
            if f"{{{word}}}" in text:
                values[word] = self._name(vehicle, form)
        return _capital(text.format(**values))

    def _ways(self) -> list[str]:
        """Where each came from: one heading told by itself, the other too or as the first one saw it."""
        scene, draw = self.scene, self.generator
        first = draw.randrange(2)
        if scene.road is RoadType.MERGING:
            return [self._way(first)] if draw.random() < 0.3 else []
        alone = self._way(first)
        if draw.random() < 0.4:
            return [alone, self._way(1 - first)]
        relation = (scene.headings[1 - first] - scene.headings[first]) % 4
        beside = self._say(
            "beside", _BESIDE[relation], a=first, street=self.streets[0 if relation % 2 == 0 else 1 - first]
        )
        return [alone, beside] if draw.random() < 0.85 else [beside, alone]

    def _way(self, vehicle: int) -> str:
        ways = _phrases()["told"]
        told = 0 if self.generator.random() < 0.4 else self.generator.randrange(len(ways))
        return self._say("told", told, a=vehicle)

    def _deeds(self) -> list[str]:
        scene, draw = self.scene, self.generator
        if scene.kind == "cross":
            turning = [at for at, action in enumerate(scene.actions) if action is not Action.MOVE_FORWARD]
            through = [at for at in range(2) if at not in turning and draw.random() < 0.5]
            return [
                *(self._say("deeds", "turn", a=at) for at in turning),
                *(self._say("deeds", "through", a=at) for at in through),
            ]
        if scene.kind == "merge":
            return [self._say("deeds", "merge", a=draw.randrange(2))]
        deed = {"out_of_the_stem": "out", "left_turn": "left_turn", "oncoming": "astray", "behind": "stop"}
        return [
            self._say("deeds", deed.get(scene.kind, "change"), a=draw.randrange(2) if scene.kind == "oncoming" else 0)
        ]

    def _surroundings(self) -> list[str]:
        """Light, weather and the limit, as far as they are told."""
        scene = self.scene
        found = [
            self._say(name, value) for name, value in (("light", scene.light), ("weather", scene.weather)) if value
        ]
        if scene.limit is not None:
            found.append(self._say("limits", scene.unit, limit=str(scene.limit)))
        return found

    def _struck(self) -> str:
        """The contact, as the headings allow it."""
        scene, draw = self.scene, self.generator
        striking, front, struck = draw.randrange(2), Side.FRONT, Side.FRONT
        if scene.kind == "behind":
            striking, struck = 1, Side.REAR
        elif scene.kind == "left_turn":
            striking, struck = 1, Side.RIGHT
        elif scene.kind in ("cross", "out_of_the_stem"):
            comes = (scene.headings[striking] - scene.headings[1 - striking]) % 4
            struck = Side.LEFT if comes == _FROM_LEFT else Side.RIGHT
        elif scene.kind in ("side_by_side", "merge"):
            front, struck = draw.choice([(Side.LEFT, Side.RIGHT), (Side.RIGHT, Side.LEFT)])
        self.contact = {"striking": striking, "striking_side": front.value, "struck_side": struck.value}
        part, hit = draw.choice(_phrases()["parts"][struck.value]), draw.choice(_phrases()["hits"])
        return self._say("contact", a=striking, part=part, hit=hit)

    def _key(self, order: Sequence[int], *, tells_place: bool, tells_lanes: bool) -> dict[str, Any]:
        scene = self.scene
        merging = scene.road is RoadType.MERGING
        striking = order.index(self.contact["striking"]) + 1
        limit = scene.limit
        if limit is not None and scene.unit == "kmh":
            limit = round(limit / KM_PER_MILE)
        return {
            "road_type": scene.road.value if tells_place else None,
            "num_lanes": scene.lanes if tells_lanes else None,
            "stem_direction": STEMS[scene.stem].value if scene.stem is not None and tells_place else None,
            "vehicles": [
                {
                    "initial_position": None if merging else HEADINGS[scene.headings[at]].value,
                    "action": scene.actions[at].value,
                    "speed_limit_mph": limit if (scene.headings[at] - scene.headings[0]) % 2 == 0 else None,
                }
                for at in order
            ],
            "env": {"time": scene.light, "weather": scene.weather},
            "collisions": [{**self.contact, "striking": striking, "struck": 3 - striking}],
        }


def _spoken(word: str, body: str, colour: str, *, is_body: bool) -> Mapping[str, Sequence[str]]:
    if is_body:
        first = [f"a {colour} {body}", f"a {body}", f"the {colour} {body}"]
    else:
        first = [f"{word}, in a {colour} {body},", f"{word}, driving a {body},", f"{word} ({body})", word]
    return {"first": first, "subject": [word], "object": [word, f"the {body}"], "owner": [f"{word}'s"]}


def _unmarked(text: str) -> tuple[NamedCrash, list[int]]:
    """A text without the marks around its names, and the vehicles in the order in which it speaks of them."""
    parts, names, at, last = list[str](), list[tuple[int, int, int]](), 0, 0
    for match in _MARK.finditer(text):
        before = text[last : match.start()]
        parts += [before, match[2]]
        at += len(before)
        names.append((at, at + len(match[2]), int(match[1])))
        at += len(match[2])
        last = match.end()
    order = [*dict.fromkeys(vehicle for _, _, vehicle in names)]
    order += [vehicle for vehicle in range(2) if vehicle not in order]
    found = tuple(Name(start, end, (order.index(vehicle),)) for start, end, vehicle in names)
    return NamedCrash("".join([*parts, text[last:]]), found, 2), order


def _capital(text: str) -> str:
    """A sentence with its first letter large, which may be that of a name within its mark."""
    at = 2 if text.startswith("\x01") else 0
    return text[:at] + text[at : at + 1].upper() + text[at + 1 :]


@cache
def _phrases() -> Any:
    table = importlib.resources.files(__package__).joinpath("made_up.yaml")
    return yaml.safe_load(table.read_text(encoding="utf-8"))

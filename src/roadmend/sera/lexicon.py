"""Which words of a driver, an engineer or a police report mean which term."""

import re
from collections import Counter

_WORD = r"[a-z][a-z0-9]+"

# Patterns on lower-case text with single spaces for hyphens; the longer ones of a group come first where they overlap.
_MEANINGS: dict[str, str] = {
    "family:S1": r"s1",
    "family:S2": r"s2",
    "family:S3": r"s3",
    "family:S4": r"s4",
    "family:S5": r"s5",
    "road:highway_exit": r"(highway |motorway |freeway )?exits?|off ?ramps?|deceleration lanes?|diverges?",
    "road:on_ramp": r"on ?ramps?|entry ramps?|slip roads?|acceleration lanes?",
    "road:tee_junction": r"t junctions?|tee( junctions?)?|three way (intersections?|junctions?)",
    "road:intersection": r"intersections?|crossroads?|junctions?",
    "control:traffic_light": r"traffic lights?|signali[sz]ed|traffic signals?|red lights?",
    "control:allway_stop": r"all ?way stops?|four way stops?",
    "control:right_before_left": r"right before left|uncontrolled|unsigned",
    "control:priority": r"priority (signs?|roads?)|yield signs?",
    "crossings:yes": r"crosswalks?|zebra( crossings?)?|pedestrian crossings?|crossings",
    "manoeuvre:left_turn": r"(turn|turns|turning|turned) left|left turn(s|ing)?",
    "manoeuvre:right_turn": r"(turn|turns|turning|turned) right|right turn(s|ing)?",
    "manoeuvre:straight": r"straight( on| ahead)?|going through|crosses straight on",
    "manoeuvre:merge": r"merg(e|es|ed|ing)",
    "hazard:cut_in_and_brake": r"(cut|cuts|cutting) in and brak(e|es|ing)|brake check(s|ed|ing)?|swoops?",
    "hazard:cut_in": r"(cut|cuts|cutting) (in|me off|us off|it off|off)|cut ins?|lane intrusions?",
    "hazard:hard_braking": r"hard brak(e|es|ing)|brak(e|es|ing|ed) hard|(sudden|emergency|abrupt) brak(e|es|ing)"
    r"|brak(e|es|ed|ing) suddenly|slams? on the brakes",
    "hazard:run_right_of_way": r"(runs?|running|ran)( a| the)? (red light|red|right of way|stop sign)"
    r"|(ignor|disregard|violat)(e|es|s|ed|ing)( the)? (right of way|red light|priority)"
    r"|(fail|fails|failed) to (yield|give way)|jump(s|ed|ing)? the light",
    "hazard:pedestrian_crossing": r"pedestrians? cross(es|ing)?( the road)?|cross(es|ing) pedestrians?|jaywalk(s|er|ers|ing)",
    "participant:car": r"cars?|sedans?|passenger vehicles?",
    "participant:truck": r"trucks?|lorr(y|ies)|semis?|trailers?|heavy goods vehicles?",
    "participant:bus": r"bus(es)?|coach(es)?",
    "participant:motorcycle": r"motor ?cycles?|motorbikes?|motorcyclists?",
    "participant:bicycle": r"bicycles?|bikes?|cyclists?",
    "participant:pedestrian": r"pedestrians?|persons? on foot|walkers?",
    "driver:reckless": r"reckless(ly)?",
    "driver:aggressive": r"aggressive(ly)?|pushy",
    "driver:careful": r"careful(ly)?|cautious(ly)?",
    "side:left": r"(from|on) (the )?left",
    "side:right": r"(from|on) (the )?right",
    "side:oncoming": r"oncoming|opposite direction|head on",
    "side:behind": r"from behind|rear",
    "side:ahead": r"ahead|in front|lead(ing)? vehicle|leader",
    "weather:clear": r"clear( weather)?",
    "weather:sunny": r"sunny|sunshine",
    "weather:cloudy": r"cloudy|clouds",
    "weather:overcast": r"overcast( sky)?",
    "weather:windy": r"windy|wind|gusts?",
    "weather:rainy": r"rain(s|y|ing|fall)?|wet( road| roads)?|drizzle",
    "weather:foggy": r"fog(gy)?|mist(y)?",
    "weather:snowy": r"snow(y|s|ing|fall)?|ic(e|y)",
    "light:nighttime": r"night( ?time)?|nights|dark(ness)?|after sunset",
    "light:daytime": r"day( ?time|light)?|by day",
    "density:dense": r"dense( traffic)?|heavy traffic|congest(ed|ion)|crowded",
    "density:light": r"light traffic|sparse( traffic)?|empty road",
    "outcome:COLLISION": r"collisions?|collid(e|es|ed|ing)|crash(es|ed|ing)?|hits?|accidents?",
    "outcome:TIMEOUT": r"time ?outs?|stuck|stands still|gets nowhere|never arrives",
    "outcome:OFF_ROUTE": r"off (the )?(route|road)|leaves the (road|route)|miss(es|ed)? the exit",
    "outcome:GOAL": r"goal reached|success(ful|es)?",
}
# What stands inside another expression must not count twice: longer matches are taken out of the text first.
_COMPILED = [(term, re.compile(rf"\b(?:{pattern})\b")) for term, pattern in _MEANINGS.items()]
IMPLIED = {"hazard:cut_in_and_brake": ("hazard:cut_in", "hazard:hard_braking")}  # who does the one does the others
_SAYING_NOTHING = """
an and are as at be been but by for from had has have he her his if in into is it its no not of on or our she
so than that the their them then there they this to too was we were when where which while who with ego
vehicle vehicles road roads driver drivers lane lanes traffic weather failure failures scenario scenarios
"""
_STOP_WORDS = frozenset(re.findall(_WORD, _SAYING_NOTHING))


def terms_of_text(text: str) -> Counter[str]:
    """Terms that a text speaks of, with counts; words unknown to the lexicon as they are."""
    rest = re.sub(r"[\s\-_/]+", " ", text.lower())
    found: list[tuple[int, int, str]] = []
    for term, pattern in _COMPILED:
        found += [(match.start(), match.end(), term) for match in pattern.finditer(rest)]
    terms: Counter[str] = Counter()
    taken_until = 0
    for start, end, term in sorted(found, key=lambda each: (each[0], -each[1])):
        if start >= taken_until:
            terms[term] += 1
            terms.update(IMPLIED.get(term, ()))
            rest = rest[:start] + " " * (end - start) + rest[end:]
            taken_until = end
    terms.update(word for word in re.findall(_WORD, rest) if word not in _STOP_WORDS)
    return terms

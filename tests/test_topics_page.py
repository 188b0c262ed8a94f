"""src/doc/topics.md says what the nodes publish: names, types and QoS from the code, and from a bag that they filled."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import pytest

from roadmend.nodes import viz
from roadmend.recording import topics
from roadmend.recording.reader import BagReader

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "src" / "doc" / "topics.md").read_text(encoding="utf-8")
ROWS = {
    cells[0].strip("`"): [cell.strip("`") for cell in cells[1:]]
    for cells in ([cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if "| `" in line)
}
NODES = ROOT / "src" / "roadmend" / "nodes"
TOPICS = {
    name: value
    for name, value in vars(topics).items()
    if name.isupper() and isinstance(value, str) and value not in (topics.PARAMETER_EVENTS, topics.SHADOW)
}
SAMPLE = ROOT / "bags" / "samples" / "repaired"


def names_in(node):
    """The topics that a piece of code names, as topics.NAME."""
    return {
        TOPICS[part.attr]
        for part in ast.walk(node)
        if isinstance(part, ast.Attribute) and getattr(part.value, "id", "") == "topics" and part.attr in TOPICS
    }


def published():
    """Topic -> the nodes that make a publisher of it, or of a class that does."""
    found = {}
    texts = {path.stem: path.read_text(encoding="utf-8") for path in NODES.glob("*.py")}
    for stem, text in texts.items():
        for made in [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ClassDef)]:
            users = {f"{name}_node" for name, other in texts.items() if f" {made.name}(" in other and name != stem}
            for node in ast.walk(made):
                if isinstance(node, ast.Call) and getattr(node.func, "attr", "").endswith("_publisher"):
                    for topic in names_in(node):
                        found.setdefault(topic, set()).update({f"{stem}_node"} if "run_node(" in text else users)
    for topic in viz._DRAWINGS:
        found.setdefault(topic, set()).add("viz_node")
    return found


def told(offer):
    words = [f"last {offer.depth}"] if offer.depth else []  # DDS does not tell a recorder how many
    words += ["latched"] if offer.is_latched else []
    if offer.deadline_ns < 10**12:
        words.append(f"deadline {offer.deadline_ns * 1e-9:g} s")
    return ", ".join(words)


def test_every_topic_is_there():
    assert set(ROWS) == set(TOPICS.values())


@pytest.mark.parametrize("topic", sorted(TOPICS.values()))
def test_who_publishes_it(topic):
    publishers = published()[topic] - {"replay_node"}
    of_all = {
        topics.DIAGNOSTICS: ("DiagnosticsReporter(", "topics.DIAGNOSTICS"),
        topics.CONFIGURATION: ("ConfigurationAnnouncer(",),
    }
    if topic in of_all:
        assert ROWS[topic][2] == "every node"
        texts = {path.stem: path.read_text(encoding="utf-8") for path in NODES.glob("*.py") if path.stem != "spinning"}
        nodes = {name: text for name, text in texts.items() if "run_node(" in text}
        assert len(nodes) > 8
        assert all(any(word in text for word in of_all[topic]) for text in nodes.values())
    else:
        assert {ROWS[topic][2]} == publishers


@pytest.mark.parametrize("topic", sorted(TOPICS.values()))
def test_its_qos(topic):
    offer = topics.OFFERS.get(topic, topics.STREAM)
    assert offer.reliability == "reliable"
    assert ROWS[topic][1] == told(offer)


@pytest.mark.parametrize("topic", sorted(TOPICS.values()))
def test_its_type_is_the_one_in_the_code(topic):
    if topic in topics.TYPES:
        assert ROWS[topic][0] == topics.TYPES[topic]
    if topic in viz._DRAWINGS:
        kind = viz._DRAWINGS[topic]
        assert ROWS[topic][0] == f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"


def test_a_bag_of_the_graph_has_them_so():
    reader = BagReader(SAMPLE)
    known = {topic.name.lstrip("/"): topic for topic in reader.topics.values()}
    for topic, (kind, *_) in ROWS.items():
        if "/_" in topic:
            assert topic not in known  # hidden
            continue
        recorded = known[topic.lstrip("/")]
        assert recorded.type_name == kind
        offer = topics.OFFERS.get(topic, topics.STREAM)
        assert {told(each) for each in recorded.offers} == {told(replace(offer, depth=0))}, topic
    assert set(known) - {topic.lstrip("/") for topic in ROWS} <= {"rosout", "repair_node/transition_event"}


def test_the_page_names_messages_that_carry_names():
    for field in re.findall(r"`(\w+)\.(\w+)`", PAGE):
        text = (ROOT / "msg" / "msg" / f"{field[0]}.msg").read_text(encoding="utf-8")
        assert re.search(rf"=\d+[^\n]*\nuint8(\[\])? {field[1]}\b", text)

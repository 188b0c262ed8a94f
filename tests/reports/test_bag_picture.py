"""Pictures of recorded episodes: the bag is written message by message, read back and drawn."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from roadmend.core.appearance import SILENT_COLOUR
from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.core.spell import Spell
from roadmend.recording import definitions
from roadmend.recording.episode import read_episode
from roadmend.recording.writer import BagWriter
from roadmend.reports.bag_picture import draw_bag, interesting_moment, timeline_of, view_of

TICKS = 100
TYPES = {
    "ego": "nav_msgs/msg/Odometry",
    "objects": "roadmend_msgs/msg/ObjectList",
    "route": "roadmend_msgs/msg/Route",
    "map": "roadmend_msgs/msg/Map",
    "events": "roadmend_msgs/msg/ScenarioEvent",
    "policy/trajectory": "roadmend_msgs/msg/Trajectory",
    "repair/state": "roadmend_msgs/msg/RepairState",
}


class Scribe:
    """Writes messages given as plain values; what is not given is zero or empty."""

    def __init__(self, bag, prefix):
        self.bag, self.prefix, self.store = bag, prefix, get_typestore(Stores.EMPTY)
        for short, name in TYPES.items():
            types = get_types_from_msg(definitions.find(name).text, name)
            self.store.register({key: kind for key, kind in types.items() if key not in self.store.fielddefs})
            bag.add_topic(f"{prefix}/{short}", name)

    def write(self, short, time_ns, **fields):
        stamp = {"sec": time_ns // 10**9, "nanosec": time_ns % 10**9}
        message = self._build(TYPES[short], {"header": {"stamp": stamp, "frame_id": "map"}, **fields})
        self.bag.write(f"{self.prefix}/{short}", time_ns, bytes(self.store.serialize_cdr(message, TYPES[short])))

    def _build(self, type_name, values):
        kind, fields = self.store.types[type_name], {}
        for name, (node, detail) in self.store.fielddefs[type_name][1]:
            given = values.get(name)
            if node.name == "NAME":
                fields[name] = self._build(detail, given or {})
            elif node.name == "BASE":
                empty = {"string": "", "bool": False}.get(detail[0], 0)
                fields[name] = empty if given is None else given
            else:
                (_, inner), length = detail
                dtype = inner[0] if isinstance(inner, tuple) else inner
                default = [0] * length
                fields[name] = (
                    given or [] if dtype == "string" else np.array(given if given is not None else default, dtype)
                )
        return kind(**fields)


def record(folder, *, prefix="", intervene=range(40, 60), outcome=2, with_state=True, scenario="car ahead"):
    with BagWriter(folder) as bag:
        scribe = Scribe(bag, prefix)
        scribe.write(
            "route",
            0,
            scenario=scenario,
            ego_length=4.0,
            ego_width=1.7,
            goal=90.0,
            time_limit=60.0,
            stage_begin=[0],
            x=[0.0, 50.0, 100.0],
            y=[0.0] * 3,
            speed_limit=[13.9] * 3,
            zone_stage=[0],
            zone_begin=[60.0],
            zone_end=[70.0],
            zone_rule=[2],
            zone_signal=[-1],
        )
        scribe.write(
            "map",
            0,
            lane_begin=[0, 2],
            lane_kind=[0, 0],
            lane_width=[3.2, 3.2],
            x=[-20.0, 100.0, -20.0, 100.0],
            y=[0.0, 0.0, 3.2, 3.2],
        )
        scribe.write("events", 0, kind=0, text="started")
        for tick in range(TICKS):
            time_ns, x = tick * 50_000_000, 0.4 * tick
            scribe.write(
                "ego",
                time_ns,
                pose={"pose": {"position": {"x": x}, "orientation": {"w": 1.0}}},
                twist={"twist": {"linear": {"x": 8.0}}},
            )
            scribe.write(
                "objects",
                time_ns,
                id=[9],
                kind=[1],
                x=[50.0],
                y=[0.0],
                yaw=[0.0],
                speed=[0.0],
                acceleration=[0.0],
                yaw_rate=[0.0],
                length=[4.0],
                width=[1.8],
            )
            scribe.write(
                "policy/trajectory",
                time_ns,
                interval=0.5,
                x=[x + 4, x + 8],
                y=[0.0] * 2,
                yaw=[0.0] * 2,
                speed=[8.0] * 2,
                behaviour="follow",
            )
            if with_state:
                acts = tick in intervene
                scribe.write(
                    "repair/state",
                    time_ns,
                    state=int(acts),
                    score=0.9 if acts else 0.1,
                    threshold=0.5,
                    policy_action=0.4,
                    repair_action=-0.8,
                    final_action=-0.8 if acts else 0.4,
                    intervened=acts,
                    trigger_id=[9] if acts else [],
                    trigger_weight=[1.0] if acts else [],
                    reason="car 9 ahead" if acts else "",
                    worth=math.nan,
                )
        scribe.write("events", TICKS * 50_000_000, kind=outcome, text="the end")
    return folder


def test_episode_is_read_as_it_was_written(tmp_path):
    episode = read_episode(record(tmp_path / "bag", prefix="/car"))
    assert episode.stamps == [tick * 50_000_000 for tick in range(TICKS)]
    assert episode.outcome == "collision"
    assert episode.route is not None
    assert episode.route.scenario == "car ahead"
    assert episode.ego[0].length == 4.0
    assert len(episode.lanes.lines(0)[0]) == 2
    timeline = timeline_of(episode)
    assert timeline.spans() == [(pytest.approx(2.0), pytest.approx(2.95))]
    assert timeline.distance[10] == pytest.approx(50.0 - 2.0 - (4.0 + 2.0))
    assert timeline.final_action[50] == pytest.approx(-0.8)
    view = view_of(episode, 50 * 50_000_000, timeline)
    assert view.repair is not None
    assert (view.repair.status, view.repair.triggers[0].object_id) == (RepairStatus.REPAIRED, 9)
    assert len(view.trail.x) == 51
    assert view.trail.intervened.sum() == 11


def test_first_intervention_is_the_moment_shown(tmp_path):
    out = tmp_path / "pictures" / "scene.png"
    drawn = draw_bag(record(tmp_path / "bag"), out)
    assert drawn == pytest.approx(2.475, abs=0.026)
    pixels = np.asarray(Image.open(out).convert("RGB"))
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 100


def test_without_intervention_the_moment_is_a_second_before_the_end(tmp_path):
    episode = read_episode(record(tmp_path / "bag", intervene=range(0), with_state=False))
    assert interesting_moment(timeline_of(episode)) == pytest.approx(3.95)
    assert np.isnan(timeline_of(episode).score).all()
    assert draw_bag(tmp_path / "bag", tmp_path / "scene.svg") == pytest.approx(3.95)


def test_a_moment_asked_for(tmp_path):
    bag = record(tmp_path / "bag")
    assert draw_bag(bag, tmp_path / "a.png", at=1.02) == pytest.approx(1.0)
    assert draw_bag(bag, tmp_path / "b.png", at=5.3) == pytest.approx(4.95)
    for wrong in (-1.0, 60.0, math.nan):
        with pytest.raises(InputError, match="outside the recording"):
            draw_bag(bag, tmp_path / "c.png", at=wrong)
    assert not (tmp_path / "c.png").exists()


def test_a_plan_that_nobody_can_use_is_drawn_as_absent(tmp_path):
    episode = read_episode(record(tmp_path / "bag"))
    plan = episode.trajectories[0]
    assert view_of(episode, 0).trajectory is plan
    episode.trajectories[0] = replace(plan, y=np.zeros(1))
    assert len(view_of(episode, 0).trajectory) == 0
    draw_bag(tmp_path / "bag", tmp_path / "scene.png", at=0.0, read=lambda _: episode)
    assert (tmp_path / "scene.png").exists()


def test_what_cannot_be_drawn_is_refused_in_one_line(tmp_path):
    with pytest.raises(InputError, match="no such bag"):
        draw_bag(tmp_path / "none", tmp_path / "a.png")
    bag = record(tmp_path / "bag")
    with pytest.raises(InputError, match="no format"):
        draw_bag(bag, tmp_path / "a.docx")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        draw_bag(bag, tmp_path / "file" / "a.png")
    with BagWriter(tmp_path / "empty"):
        pass
    with pytest.raises(InputError, match="no odometry"):
        draw_bag(tmp_path / "empty", tmp_path / "a.png")


def data_of(page):
    return json.loads(page.partition('<script type="application/json" id="data">')[2].partition("</script>")[0])


def test_a_page_stands_alone_and_holds_each_tick(tmp_path):
    bag = record(tmp_path / "bag")
    assert draw_bag(bag, tmp_path / "page.html", at=2.0) == pytest.approx(2.0)
    page = (tmp_path / "page.html").read_text("utf-8")
    assert "@@" not in page
    assert not re.findall(r"""(?:src|href|url)\s*[=(]\s*["']?(?!#)[\w/.:]+""", page)  # nothing from elsewhere
    assert "car ahead" in page.partition("<svg")[2]
    data = data_of(page)
    assert re.findall(r"<button[^>]*>([^<]*)<", page) == ["intervened 2.00 to 2.95 s", "collision 5.00 s"]
    assert data["now"] == pytest.approx(2.0)
    assert data["time"] == pytest.approx([0.05 * tick for tick in range(TICKS)])
    assert data["sent"][39:41] == [0.4, -0.8]
    assert data["states"][str(data["state"][50])][0] == "repaired"
    assert data["reasons"][data["reason"][50]] == "car 9 ahead"
    assert [kind for _, kind, _ in data["events"]] == ["STARTED", "COLLISION"]
    left, right, top, bottom = data["box"]
    assert 0 < left < right < 1
    assert 0.5 < top < bottom < 1
    draw_bag(bag, tmp_path / "again.html", at=2.0)
    assert (tmp_path / "again.html").read_text("utf-8") == page
    assert not [*tmp_path.glob(".*")]


def test_a_page_lists_the_interventions_with_who_and_why(tmp_path):
    bag = record(tmp_path / "bag", intervene=[*range(20, 25), *range(40, 60)])
    draw_bag(bag, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text("utf-8")
    rows = rows_of(page)
    assert [row[:5] for row in rows] == [["1", "1.00", "0.25", "0.30", "-0.80"], ["2", "2.00", "1.00", "1.20", "-0.80"]]
    assert rows[1][5:] == ["\N{EN DASH}", "car 9 ahead, 30 m", "car 9 ahead"]  # no worth is told, and nobody has looked
    assert "rescue" not in page
    draw_bag(bag, tmp_path / "page.html", spells=[Spell(2.0, 20, 24.0, 0.05)])
    page = (tmp_path / "page.html").read_text("utf-8")
    assert [row[6:8] for row in rows_of(page)] == [["\N{EN DASH}", ""], ["0.05", "nuisance"]]


def rows_of(page):
    """The texts of the table of interventions."""
    body = page.partition('<table id="spells">')[2].partition("<tbody>")[2].partition("</tbody>")[0]
    cells = [re.findall(r"<td>(.*?)</td>", row, re.DOTALL) for row in body.split("</tr>")[:-1]]
    return [[re.sub("<[^>]*>", "", cell) for cell in row] for row in cells]


def test_texts_of_a_bag_cannot_break_out_of_the_page(tmp_path):
    evil = "</script><script>@@DATA@@ & <b>"
    draw_bag(record(tmp_path / "bag", scenario=evil), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text("utf-8")
    assert page.count("<script") == 2
    assert "<b>" not in page
    assert data_of(page)["reasons"] == ["", "car 9 ahead"]


def test_a_page_without_repair_states_has_their_values_empty(tmp_path):
    draw_bag(record(tmp_path / "bag", with_state=False), tmp_path / "page.html")
    data = data_of((tmp_path / "page.html").read_text("utf-8"))
    assert set(data["score"]) == {None}
    assert data["states"] == {"-1": ["silent", SILENT_COLOUR]}

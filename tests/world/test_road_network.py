"""Networks that SUMO did not write: each is refused in a line before anything is built on it."""

import pytest

from roadmend.core.errors import InputError
from roadmend.core.route import RightOfWay
from roadmend.world.road_network import read_network
from roadmend.world.route_builder import build_route
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_networks import NetworkFile

EDGE = '<edge id="{0}" function="{1}"><lane id="{0}_0" index="0" speed="13.9" length="50" shape="{2}"/></edge>'
INTO, INSIDE, OUT = "0,0 50,0", "50,0 60,0", "60,0 110,0"
CONNECTIONS = (
    '<connection from="a" to="b" fromLane="0" toLane="0" via=":n_0_0" dir="s" state="M"/>'
    '<connection from=":n_0" to="b" fromLane="0" toLane="0" dir="s" state="M"/>'
)


@pytest.fixture
def network(tmp_path):
    def write(into=INTO, inside=INSIDE, out=OUT, crossing="55,-5 55,5", connections=CONNECTIONS):
        edges = [
            ("a", "normal", into),
            (":n_0", "internal", inside),
            ("b", "normal", out),
            (":n_c0", "crossing", crossing),
        ]
        text = "".join(EDGE.format(*each) for each in edges)
        (tmp_path / "n.net.xml").write_text(f"<net>{text}{connections}</net>")
        return tmp_path / "n.net.xml"

    return write


def route_on(path, *edges, **ego):
    scenario = Scenario(name="n", network=NetworkFile(path=str(path)), ego=Ego(route=edges or ("a", "b"), **ego))
    return build_route(read_network(path), scenario).route


def test_a_sound_one(network):
    (stage,) = route_on(network()).stages
    assert (stage.x[0], stage.x[-1]) == (0.0, 110.0)


@pytest.mark.parametrize(
    ("edges", "ego", "complaint"),
    [
        (
            "a",
            {"position": 20.0, "goal": 10.0},
            r"ego\.goal: the ego starts at 20 m, .* not ahead \(10\.0 m\); .*larger",
        ),
        ("a", {"position": 20.0, "goal": 20.0}, r"ego\.goal: .*\(20\.0 m\)"),
        ("a", {"position": 48.0}, r"ego\.position: the ego starts at 48 m, .*\(43\.6 m\); choose a smaller one"),
    ],
)
def test_a_goal_that_is_not_ahead(edges, ego, complaint, network):
    with pytest.raises(InputError, match=complaint):
        route_on(network(), *edges, **ego)
    assert route_on(network(), "a", "b", position=20.0, goal=10.0).goal == 70.0


@pytest.mark.parametrize("place", ["into", "inside", "out", "crossing"])
@pytest.mark.parametrize("shape", ["", "1,1", "nan,0 50,0", "0,0 inf,0"])
def test_a_lane_without_a_line(place, shape, network):
    with pytest.raises(InputError, match=r"n\.net\.xml: is no SUMO network \(lane '.*_0' has no shape of two points"):
        read_network(network(**{place: shape}))


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('via=":n_0_0"', 'via=":none_0_0"', r"from 'a' to 'b' leads over ':none_0_0', which is not there"),
        ('via=":n_0_0"', 'via=":n_0_7"', "leads over ':n_0_7'"),
        ('via=":n_0_0"', 'via="word"', "leads over 'word'"),
        ('toLane="0"', 'toLane="3"', "leads to lane 3, which is not there"),
        ('toLane="0"', 'toLane="-1"', "leads to lane -1"),
    ],
)
def test_a_connection_to_nowhere(old, new, complaint, network):
    with pytest.raises(InputError, match=complaint):
        read_network(network(connections=CONNECTIONS.replace(old, new, 1)))


@pytest.mark.timeout(20)
def test_a_way_that_never_leaves_a_junction(network):
    around = CONNECTIONS.replace('from=":n_0" to="b"', 'from=":n_0" to="b" via=":n_0_0"')
    with pytest.raises(InputError, match=r"n\.net\.xml: the way from 'a' through its junction comes back to ':n_0_0'"):
        route_on(network(connections=around))


def test_without_ways_through_its_junctions_a_network_has_its_right_of_way_all_the_same(network):
    straight = '<connection from="a" to="b" fromLane="0" toLane="0" dir="s" state="m"/>'
    (zone,) = route_on(network(connections=straight, crossing="55,50 55,60")).zones
    assert (zone.begin, zone.end, zone.rule) == (50.0, 60.0, RightOfWay.YIELD)


@pytest.mark.parametrize("inside", [INSIDE, "50,0 50.2,0"])
def test_a_light_need_not_stand_at_a_junction(network, inside):
    lit = CONNECTIONS.replace('via=":n_0_0"', 'via=":n_0_0" tl="n" linkIndex="0"')
    end = float(inside.split()[1].split(",")[0])
    route = route_on(network(inside=inside, out=f"{end},0 110,0", crossing="55,50 55,60", connections=lit))
    (zone,) = route.zones
    assert (zone.begin, zone.rule) == (50.0, RightOfWay.SIGNAL)
    assert zone.end == max(end, 50.5)


def test_a_crossing_that_is_passed_twice_is_two_zones(network):
    """Out along the road, round a loop and back over the same crossing."""
    there, loop, back = "0,0 50,0", "50,0 90,0 90,40 0,40 0,0.5", "0,0.5 110,0.5"
    zones = [zone for zone in route_on(network(there, loop, back, crossing="20,-5 20,5")).zones if zone.rule == 4]
    assert [zone.end - zone.begin for zone in zones] == pytest.approx([4.7, 4.7])
    assert zones[0].end < 25.0
    assert zones[1].begin > 200.0


def test_a_route_without_a_length(network):
    with pytest.raises(InputError, match=r"ego\.route: 'a' has no length"):
        route_on(network("0,0 0,0", "0,0 0,0", "0,0 0,0"))

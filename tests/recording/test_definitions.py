import pytest

from roadmend.core.errors import InputError
from roadmend.recording import definitions
from roadmend.recording.definitions import Definition, computed_hash, find

from .idl import HEADER_IDL

TYPES = [
    "std_msgs/msg/String",
    "nav_msgs/msg/Odometry",
    "visualization_msgs/msg/MarkerArray",
    "rcl_interfaces/msg/Log",
    "tf2_msgs/msg/TFMessage",
    "roadmend_msgs/msg/ObjectList",
    "roadmend_msgs/msg/ScenarioEvent",
]


@pytest.fixture
def prefix(tmp_path, monkeypatch):
    """A prefix with a package of its own, searched first."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    folder = tmp_path / "share" / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    find.cache_clear()
    yield folder
    find.cache_clear()


@pytest.mark.parametrize("type_name", TYPES)
def test_the_installed_hash_is_the_hash_of_the_text_found(type_name):
    found = find(type_name)
    assert definitions._installed_hash(type_name) == found.type_hash == computed_hash(type_name, found.text)


def test_short_and_full_names_mean_the_same():
    assert find("std_msgs/Header") == find("std_msgs/msg/Header")


def test_parts_are_separated_as_rosbag2_does_it():
    text = find("std_msgs/msg/Header").text
    own, contained = text.split("\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\n")
    assert "string frame_id" in own
    assert "uint32 nanosec" in contained


def test_each_contained_type_appears_once(prefix):
    (prefix / "Inner.msg").write_text("int8 value\n")
    (prefix / "Middle.msg").write_text("Inner one\nInner[2] two\n")
    (prefix / "Outer.msg").write_text("Middle[<=3] a\nmy_msgs/Inner b\nmy_msgs/msg/Inner c\nstd_msgs/Header[] d\n")
    parts = [line for line in find("my_msgs/msg/Outer").text.splitlines() if line.startswith("MSG: ")]
    names = ["my_msgs/Inner", "my_msgs/Middle", "std_msgs/Header", "builtin_interfaces/Time"]
    assert parts == [f"MSG: {name}" for name in names]


def test_the_hash_is_computed_where_none_is_installed(prefix):
    (prefix / "Inner.msg").write_text("int8 value\n")
    assert find("my_msgs/msg/Inner").type_hash.startswith("RIHS01_")


def test_the_hash_of_what_rosbag2_writes_as_idl_is_that_of_the_message():
    assert computed_hash("std_msgs/msg/Header", HEADER_IDL, "ros2idl") == find("std_msgs/msg/Header").type_hash


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Other one\n", r"definition of my_msgs/msg/Outer: lacks the type 'my_msgs/msg/Other'; give it whole"),
        ("%%%", "definition of my_msgs/msg/Outer: cannot be parsed; "),
    ],
)
def test_a_definition_without_its_parts_or_without_sense_is_one_line(text, message):
    with pytest.raises(InputError, match=message):
        computed_hash("my_msgs/msg/Outer", text)


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("std_msgs/Header header\nint8 a", "std_msgs/Header"),
        ("# Header first\n\nuint8 KIND=1\nstring NAME = 'x'\nstd_msgs/msg/Header header", "std_msgs/Header"),
        ("Other[] others", "my_msgs/Other[]"),
        ("Other[<=4] others", "my_msgs/Other[]"),
        ("string<=10 name 'default'", "string"),
        ("float64[3] x", "float64[]"),
        ("int8 A=1", ""),
        ("", ""),
        ("int8 a\n" + "=" * 80 + "\nMSG: std_msgs/Header\nx/Y z", "int8"),
    ],
)
def test_first_field(text, first):
    assert Definition("my_msgs/msg/Thing", text, "").first_field == first


def test_a_missing_type_is_named():
    with pytest.raises(InputError, match=r"^no_such_msgs/Thing: no such message type is installed; install"):
        find("no_such_msgs/msg/Thing")


def test_a_missing_contained_type_is_named(prefix):
    (prefix / "Outer.msg").write_text("absent_msgs/Inner inner\n")
    with pytest.raises(InputError, match=r"^absent_msgs/Inner: "):
        find("my_msgs/msg/Outer")


@pytest.mark.parametrize(
    "name", ["", "Header", "std_msgs/srv/Empty", "../etc/passwd", "std_msgs/msg/../Header", "a/b/c/d"]
)
def test_what_is_no_type_name_is_refused(name):
    with pytest.raises(InputError, match="is not the name of a message type"):
        find(name)


def test_an_unreadable_definition_is_named(prefix):
    (prefix / "Broken.msg").write_bytes(b"int8 a # \xff\n")
    with pytest.raises(InputError, match=r"Broken\.msg: cannot be read"):
        find("my_msgs/msg/Broken")

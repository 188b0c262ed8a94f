"""What nodes have announced of themselves, without ROS: who drove and who repaired is read off here and nowhere else."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

EXTERNAL = "external"  # a policy that is somebody else's node, and what its label begins with
UNKNOWN = "unknown"  # where nobody of that role was heard of
OURS = "roadmend.nodes."  # how the class of a node of this package begins
PARAMETER = "parameters."  # what the key of a parameter begins with; its value is JSON
_ROLES = {"policy": "policy", "method": "repair"}  # in tables and bags: whose part in the graph


@dataclass(frozen=True, slots=True)
class Announcement:
    """What one node says that it is, after files and overrides.

    The keys of ``values`` that have a meaning to others: ``role`` (policy, repair, sim, ...), ``node_class``, ``class``
    (of what drives or repairs), ``package`` with its version, ``model`` (its file's name), ``model_sha256``,
    ``threshold``, ``origin`` and ``code_sha256`` of code from outside, and ``parameters.NAME``, whose values are JSON.
    """

    node: str  # its name with the namespace, as "/policy_node"
    label: str  # what it calls what it runs, such as "modular"
    values: Mapping[str, str] = field(default_factory=dict)

    @property
    def role(self) -> str:
        """Its part in the graph."""
        return self.values.get("role", "")

    @property
    def is_ours(self) -> bool:
        """Whether the node, not only what it runs, is of this package."""
        return self.values.get("node_class", "").startswith(OURS)

    @property
    def parameters(self) -> dict[str, Any]:
        """By name; a value that is no JSON is the text that it is."""
        return {
            key.removeprefix(PARAMETER): _plain(value)
            for key, value in self.values.items()
            if key.startswith(PARAMETER)
        }

    def as_dict(self) -> dict[str, Any]:
        """For people and programs: parameters by name, apart from the rest."""
        others = {key: value for key, value in self.values.items() if not key.startswith(PARAMETER)}
        return {"label": self.label, **others, "parameters": self.parameters}

    @property
    def full_label(self) -> str:
        """The label, with the mark of a node that is somebody else's."""
        return self.label if self.is_ours else f"{EXTERNAL}:{self.label or self.node}"


def account(announced: Mapping[str, Announcement], drivers: Iterable[str], repairers: Iterable[str]) -> dict[str, str]:
    """What a run is labelled with: who sent the commands, as the nodes themselves have said.

    Args:
        announced: by the node's name.
        drivers: names of the nodes that published the policy's commands.
        repairers: names of the nodes that published the repaired commands.

    Returns:
        Named texts: ``policy`` and ``method`` with the details of each behind an underscore, as in ``policy_model``;
        ``clock`` and ``seed``; ``configuration``, JSON of all that was announced.
    """
    known: dict[str, str] = {}
    for key, names in (("policy", drivers), ("method", repairers)):
        known |= _part(key, announced, sorted(set(names)))  # whoever was heard of first
    for name, role in (("clock", "sim"), ("seed", "repair")):
        said = [one.parameters[name] for one in announced.values() if one.role == role and name in one.parameters]
        if said:
            known[name] = str(said[0])
    return known | {"configuration": json.dumps({name: asdict(one) for name, one in sorted(announced.items())})}


def _part(key: str, announced: Mapping[str, Announcement], names: list[str]) -> dict[str, str]:
    """Label and details of those who sent one kind of command."""
    if not names:  # nobody was seen to; whoever said that it does is still the one to name
        names = [name for name, one in announced.items() if one.role == _ROLES[key]]
    if not names:
        return {key: UNKNOWN}
    heard = [announced.get(name, Announcement(name, "")) for name in names]
    known = {key: " + ".join(one.full_label for one in heard), f"{key}_node": " + ".join(names)}
    known[f"{key}_is_own"] = json.dumps(len(heard) == 1 and heard[0].is_ours)
    if len(heard) > 1:
        return known  # the details of each are in the configuration
    details = {name: value for name, value in heard[0].values.items() if not name.startswith(PARAMETER)}
    known |= {f"{key}_{name}": value for name, value in details.items() if name != "role"}
    if heard[0].parameters:
        known[f"{key}_parameters"] = json.dumps(heard[0].parameters)
    return known


def _plain(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text

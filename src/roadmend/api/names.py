"""The names that ``roadmend`` offers, and where each is at home; type checkers read them in src/roadmend/__init__.pyi.

Whoever builds on roadmend may rely on these: one that is here stays, and means what it means.
"""

HOMES = {
    # what to call
    "evaluate": "roadmend.api.evaluation",
    "load_scenario": "roadmend.api.scenarios",
    "load_scenarios": "roadmend.api.scenarios",
    "read_bag": "roadmend.api.bag",
    "run": "roadmend.api.run",
    "sample_scenario": "roadmend.world.families",
    # what comes of it
    "BagTables": "roadmend.api.bag",
    "EpisodeResult": "roadmend.core.episode_result",
    "EvaluationReport": "roadmend.api.evaluation",
    "Event": "roadmend.core.outcome",
    "EventKind": "roadmend.core.outcome",
    "Repair": "roadmend.core.repair",
    "RepairStatus": "roadmend.core.repair",
    "Scenario": "roadmend.world.scenario",
    "Tick": "roadmend.core.tick",
    # what a policy or a repair method of one's own is made of
    "Command": "roadmend.core.command",
    "Decision": "roadmend.core.command",
    "EgoState": "roadmend.core.scene",
    "ObjectKind": "roadmend.core.scene",
    "ObjectList": "roadmend.core.scene",
    "Parameters": "roadmend.core.parameters",
    "Policy": "roadmend.core.interfaces",
    "Proposal": "roadmend.core.repair",
    "RepairMethod": "roadmend.repair.method",
    "RepairTrigger": "roadmend.core.repair",
    "Route": "roadmend.core.route",
    "Scene": "roadmend.core.scene",
    "Signal": "roadmend.core.scene",
    "Trajectory": "roadmend.core.command",
    # what is raised
    "ForeignError": "roadmend.core.errors",
    "InputError": "roadmend.core.errors",
    "RoadmendError": "roadmend.core.errors",
    "SimulationError": "roadmend.core.errors",
}

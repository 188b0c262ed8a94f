"""Health on /diagnostics: what gets worse is said at once, and once."""

import pytest
import rclpy
from rclpy.node import Node

from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level


class Patient:
    """A node whose health is in the test's hands, and what is published of it."""

    def __init__(self, node):
        self.level, self.said = Level.OK, []
        self.reporter = DiagnosticsReporter(node, lambda: Health(self.level, self.level.name))
        self.reporter._publisher = self

    def publish(self, message):
        self.said.append(message.status[0].message)


@pytest.fixture
def patient(domain):
    rclpy.init(domain_id=domain)
    node = Node("patient")
    yield Patient(node)
    node.destroy_node()
    rclpy.try_shutdown()


def test_what_gets_worse_is_said_at_once_and_once(patient):
    for level in (Level.WARN, Level.WARN, Level.ERROR, Level.WARN, Level.ERROR):
        patient.level = level
        patient.reporter.complain(level)
    assert patient.said == ["WARN", "ERROR"]


def test_after_it_was_well_again_it_is_said_anew(patient):
    for level in (Level.ERROR, Level.OK, Level.ERROR):
        patient.level = level
        patient.reporter.complain(level)
        patient.reporter.publish()  # as once a second
    assert patient.said == ["ERROR", "ERROR", "OK", "ERROR", "ERROR"]


def test_a_complaint_that_the_health_does_not_share_is_not_said_at_every_tick(patient):
    for _ in range(5):
        patient.reporter.complain(Level.ERROR)
    assert patient.said == ["OK"]

"""A lifecycle node that outlives every request: a transition that its state does not have is refused, not fatal.

rclpy lets the error of such a request out of the executor, and with it ends the node.
"""

from collections.abc import Callable
from typing import Any

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn


class SteadyLifecycleNode(LifecycleNode):
    """Answers a request for a transition that it cannot make with ``success: false``, and says why on its log."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        service = self._service_change_state  # rclpy offers no other way to stand before it
        service.callback = self._refusing(service.callback)

    def _refusing(self, change: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def answer(request: Any, response: Any) -> Any:
            state, wanted = self._state_machine.current_state[1], request.transition
            try:
                response = change(request, response)
            except Exception as error:  # noqa: BLE001 - whatever is asked for, the node stays
                response.success = False
                self.get_logger().error(f"transition failed: {error!r}")
            if not response.success:
                there = ", ".join(f"{one[0]} {one[1]}" for one in self._state_machine.available_transitions)
                asked = wanted.label or wanted.id
                self.get_logger().warning(f"transition {asked} refused in state {state}; possible: {there or 'none'}")
            return response

        return answer

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """A transition raised: back to unconfigured, from where it can be tried again."""
        self.get_logger().error(f"a transition from {state.label} failed; unconfigured now")
        return super().on_error(state)

"""Which model a policy drives with: what is found with one says nothing about another."""

from roadmend.policies.registry import make_policy


def policy_model(policy: str) -> str | None:
    """SHA-256 of the policy's model file, hexadecimal; None for a policy without one.

    Raises:
        InputError: there is no such policy, or its model cannot be read.
    """
    digest: str | None = getattr(make_policy(policy), "model_digest", None)
    return digest

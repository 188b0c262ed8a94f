"""From a crash report to scenarios that test the policy (SAFE)."""

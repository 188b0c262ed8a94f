"""Where the command line begins: before all that takes a moment to import."""

import sys


def main() -> int:
    """Run the command of ``sys.argv``; an interrupt while the rest is imported ends it as any other does."""
    try:
        from roadmend.cli.main import main as command_line  # noqa: PLC0415 - see above
    except KeyboardInterrupt:
        print("roadmend: interrupted", file=sys.stderr)
        return 130
    return command_line()

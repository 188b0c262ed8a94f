"""What stands behind --ros-args on the command line; it goes to the nodes as it is."""

import click

ROS_ARGUMENTS = click.argument("ros_arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--ros-args ...]")


def ros_arguments(given: tuple[str, ...]) -> tuple[str, ...]:
    """What stands behind --ros-args.

    Raises:
        click.UsageError: something else stands there; with the nearest options where it looks like one.
    """
    if given and given[0] != "--ros-args":
        context = click.get_current_context()
        options = [name for option in context.command.get_params(context) for name in option.opts]
        if given[0].startswith("-"):
            raise click.NoSuchOption(given[0].partition("=")[0], possibilities=options, ctx=context)
        raise click.UsageError(f"unexpected argument {given[0]!r}", ctx=context)
    return given[1:]

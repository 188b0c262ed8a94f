"""Options that many commands have."""

import os

import click

WORKERS = click.option("--workers", default=os.cpu_count() or 1, show_default="cores", type=click.IntRange(1, 256))

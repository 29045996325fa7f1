"""`python -m orchestrator` is the command line `curvesqueal`."""

import os


def main() -> None:
    """Run the command line; Ctrl-C while it is being loaded is no fault of the program either."""
    try:
        from .cli import main as command_line  # noqa: PLC0415 - what may be interrupted

        command_line()
    except KeyboardInterrupt:
        os._exit(130)


if __name__ == "__main__":
    main()

"""`python -m orchestrator`."""

import gc

from orchestrator.basis.interruption import end_at_once


def main() -> int:
    """Run one command and return its exit code.

    What importing makes stays for good: looking for garbage in it took a tenth of a second of `limit` on benchmark 1.
    app/commands.py switches it on again, and lets Ctrl-C end a command in order.
    """
    end_at_once()
    gc.disable()
    from orchestrator.app import cli

    return cli.main()


if __name__ == "__main__":
    raise SystemExit(main())

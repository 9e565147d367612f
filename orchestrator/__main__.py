"""`python -m orchestrator`."""

import gc


def main() -> int:
    """Run one command and return its exit code.

    What importing makes stays for good: looking for garbage in it took a tenth of a second of `limit` on benchmark 1.
    app/commands.py switches it on again.
    """
    gc.disable()
    from orchestrator.app import cli

    return cli.main()


if __name__ == "__main__":
    raise SystemExit(main())

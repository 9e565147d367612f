"""What is said of samples: fractiles of the fragility that is written, and nothing that a few samples do not tell."""

from __future__ import annotations

from collections import Counter

import pytest

from orchestrator.app.sensitivity_runs import SensitivityOutcome, words


def said_of(*samples):
    kind = "collapse state"
    return words(SensitivityOutcome("base shear (kN)", 1.0, kind, (), samples, None, Counter({kind: len(samples)}), ()))


def test_fractiles_are_those_of_the_fragility():
    """The i-th of 16 stands at (i - 1/2) / 16: 5 % lies 0.3 above the first. It was told 0.75 above it."""
    (said,) = said_of(*map(float, range(1, 17)))
    assert said == (
        "16 samples, base shear (kN): from 1 to 16, 5 % fractile 1.3, median 8.5, 95 % fractile 15.7."
    )  # fmt: skip


@pytest.mark.parametrize(("samples", "median"), [((2.0,), "2"), (tuple(map(float, range(1, 10))), "5")])
def test_few_samples_have_no_fractiles(samples, median):
    (said,) = said_of(*samples)
    assert said.endswith(f", median {median}.")

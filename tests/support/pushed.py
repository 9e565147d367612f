"""The summary of a pushover, made by hand: 6.6 kN at 5.9 mm."""

from __future__ import annotations

from orchestrator.storage.summary import PushoverSummary

PUSHED = PushoverSummary(
    model="micro", bodies=4, nodes=90, tetrahedra=200, contacts=30, displacements="large", ranks=1, steps=20,
    moving_steps=0, newton_iterations=60, rescues={}, energy_error=1e-6, events=(), max_penetration=0.0,
    max_penetration_over_size=0.0, peak_base_shear=6595.86, peak_multiplier=0.296776, displacement_at_peak=5.8756e-3,
    final_displacement=0.02, initial_stiffness=39.0764e6, equilibrium_residual=1e-9, peak_reached=True,
    seconds=dict.fromkeys(("mesh", "assembly", "factorise", "contact", "total"), 5.678), peak_memory=273_682_432,
    stopped_because="done", complaint=None, valid=True, not_valid_because=None,
)  # fmt: skip

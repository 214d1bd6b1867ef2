"""The record of the harmonic engine."""

from femic.late import Late
from femic.reference.engine import Comparison, Engine, ErrorEstimate, Limits, Matrices, Models
from femic.reference.harmonic import tuned

HARMONIC_SAFETY = 2.0  # with it the estimate bounds 99 of 100 errors where C is known
displacements = Late("femic.reference.harmonic.synthesis:displacements")

HARMONIC = Engine(
    name="harmonic",
    description="harmonic: quartic triangles of the section",
    limits=Limits(nu=0.4999, aspect=100.0, rolling_radius=20.0, inclination=85.0, distance=1e4),
    tuned=tuned.TUNED,
    far_radius=tuned.far_radius,
    least_side=tuned.least_side,
    infinite_length=True,
    solves_transposes=True,
    outlines=True,
    shares_a_model=True,
    estimate=ErrorEstimate(models=("fine",), safety=HARMONIC_SAFETY, growth_of_unknowns=2.0),
    models=Models(
        request=Late("femic.reference.harmonic.request:request_for"),
        solve=Late("femic.reference.harmonic.tasks:solve_tasks"),
        key=Late("femic.reference.harmonic.nesting:model_key"),
        displacements=lambda request, solved: displacements(solved, request.loads, request.points),
        expected_cost=Late("femic.reference.harmonic.plan:expected_cost"),
    ),
    matrices=Matrices(
        tuned.TUNED_ON_STRIPS,
        tuned.far_radius_of_grid,
        request=Late("femic.reference.harmonic.request:request_on_strips"),
        columns=Late("femic.reference.harmonic.lags:syntheses"),
        displacements=displacements,
    ),
    comparison=Comparison((1e-1, 1e-2, 1e-3, 1e-4), colour="black", marker="s"),
)

"""The judge: frictionless contact of two meshed bodies, without any influence coefficients.

    from femic.contact.finite_elements.result import judge
    from femic.contact.finite_elements.levels import Bodies

    judged = judge(Bodies(lower, upper, s_range=lower.contour.limits), load=58e3)
    judged.numbers.p_max, judged.estimate.p_max

Modules: `bodies` (mesh, stiffness, multigrid), `overlap` and `coupling` (mortar), `saddle` (displacements,
pressures and approach for a given contact area), `active_set` (the area), `extent` (its edges), `levels` (a
contact on one pair of meshes), `judgement` (meshes made for the patch, and estimates). Imports femic,
approx, geometries.
"""

"""Systems of elasticity on quadratic tetrahedra: their stiffness, and their solution.

The stiffness of isotropic bodies has 3 x 3 blocks per pair of nodes. Systems are solved by conjugate
gradients with multigrid, or by a sparse direct solver.

Multigrid: one step from quadratic to linear elements (the vertices), then PyAMG's smoothed
aggregation with 3 x 3 blocks and the six rigid-body modes. One sweep before and the reversed one after the
correction make a symmetric cycle. Held components stay in the system as rows of the unit matrix (scaled),
with zeros in the modes, so that the blocks stay complete.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pyamg
from pyamg.multilevel import MultilevelSolver
from pyamg.relaxation.smoothing import change_smoothers
from scipy.sparse import bsr_matrix, csr_matrix, diags_array, kron, triu
from scipy.sparse.linalg import LinearOperator, cg
from skfem import Basis, ElementTetP2, MeshTet2

from femic.cache.workers import one_blas_thread
from femic.reference.engine import SolverChoice
from femic.reference.job import NotConverged
from femic.reference.solid import pardiso
from geometries.arrays import Array, Mask
from geometries.materials import Material

# --- stiffness ---

# Orders of quadrature rules with positive weights (rules of order 3 and 4 have negative ones). The first is
# exact for the stiffness of straight cells; the second reproduces constant strain on curved cells.
STRAIGHT_ORDER, CURVED_ORDER = 2, 5
CELLS_AT_ONCE = 10_000  # number of cells at a time, to bound memory


def stiffness(mesh: MeshTet2, material: Material) -> bsr_matrix:
    """Stiffness matrix [N/mm], shape (3 n_nodes, 3 n_nodes); unknowns are x, y, z node by node.

    Block (a, b) is the integral of lambda grad_a grad_b^T + G (grad_b grad_a^T + grad_a.grad_b 1).
    """
    nodes = mesh.dofs.element_dofs.T.astype(np.int64)  # (n_cells, 10)
    n_nodes = mesh.doflocs.shape[1]
    entries, entry_number = np.unique(
        (nodes[:, :, None] * n_nodes + nodes[:, None, :]).ravel(), return_inverse=True
    )
    entry_number = entry_number.reshape(len(nodes), -1)
    data = np.zeros((len(entries), 9))
    curved = is_curved(mesh)
    chunks = [  # of straight, then of curved cells, with the order of their quadrature
        (cells[start : start + CELLS_AT_ONCE], order)
        for cells, order in (
            (np.flatnonzero(~curved), STRAIGHT_ORDER),
            (np.flatnonzero(curved), CURVED_ORDER),
        )
        for start in range(0, len(cells), CELLS_AT_ONCE)
    ]
    for cells, order in chunks:
        basis = Basis(mesh, ElementTetP2(), elements=cells, intorder=order)
        grad = np.stack([basis.basis[a][0].grad for a in range(basis.Nbfun)])  # (10, 3, n_cells, n_q)
        products = np.einsum("aieq,bjeq,eq->eabij", grad, grad, basis.dx, optimize=True)
        dot = np.einsum("eabkk->eab", products)[..., None, None]
        blocks = material.lame * products + material.G * (np.swapaxes(products, -1, -2) + dot * np.eye(3))
        blocks = blocks.reshape(-1, 9)
        for component in range(9):
            data[:, component] += np.bincount(
                entry_number[cells].ravel(), blocks[:, component], minlength=len(entries)
            )
    rows = np.searchsorted(entries, np.arange(n_nodes + 1) * n_nodes)
    return bsr_matrix((data.reshape(-1, 3, 3), entries % n_nodes, rows), shape=(3 * n_nodes, 3 * n_nodes))


def is_curved(mesh: MeshTet2) -> Mask:
    """Whether a mid-side node of a cell lies off the middle of its edge, shape (n_cells,)."""
    middle = mesh.doflocs[:, mesh.edges].mean(axis=1)
    mid_nodes = mesh.doflocs[:, mesh.nvertices :]
    length = np.linalg.norm(np.ptp(mesh.doflocs[:, mesh.edges], axis=1), axis=0)
    bent = np.linalg.norm(mid_nodes - middle, axis=0) > 1e-10 * length
    return np.any(bent[mesh.t2e], axis=0)


def rigid_body_modes(nodes: Array) -> Array:
    """Three translations and three rotations about x, y, z through the origin, shape (3 n_nodes, 6)."""
    x, y, z = nodes
    zero = np.zeros_like(x)
    rotations = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]])  # (component, axis, node)
    translations = np.broadcast_to(np.eye(3)[:, :, None], rotations.shape)
    return np.moveaxis(np.concatenate([translations, rotations], axis=1), 2, 0).reshape(-1, 6)


# --- solvers ---

MAX_ITERATIONS = 300
DIRECT_LIMIT = 80_000  # largest number of unknowns for which the direct solver is faster
SMOOTHERS = tuple(("block_gauss_seidel", {"sweep": sweep}) for sweep in ("forward", "backward"))


@dataclass(frozen=True)
class System:
    """A stiffness matrix with held components and what multigrid needs.

    `modes` are the rigid-body modes; `from_vertices` takes values at vertices to all nodes.
    """

    matrix: bsr_matrix
    held: Mask  # (n_nodes, 3)
    modes: Array  # (3 n_nodes, 6)
    from_vertices: csr_matrix  # (n_nodes, n_vertices)


@dataclass(frozen=True)
class Solution:
    """Nodal displacements (n_nodes, 3) [mm/N], with the solver that found them and its residual."""

    displacement: Array
    solver: str
    iterations: int  # 0 for the direct solver
    residual: float  # ||f - K u|| / ||f|| over the free components


def prepare(system: System, solver: SolverChoice, *, n_loads: int = 1) -> Callable[[Array, float], Solution]:
    """Factor the matrix or build the hierarchy once; the result solves K u = f to a relative residual.

    "auto" takes the direct solver where it is installed and was measured to be faster
    (docs/evidence/performance.md): for several loads on one matrix of moderate size. The result raises
    NotConverged where the residual is more than twice as large as required.
    """
    direct_is_faster = n_loads > 1 and system.matrix.shape[0] <= DIRECT_LIMIT
    if solver == "direct" or (solver == "auto" and direct_is_faster and pardiso.available()):
        return _prepare_direct(system)
    return _prepare_multigrid(system)


def _prepare_multigrid(system: System) -> Callable[[Array, float], Solution]:
    """A solver by conjugate gradients with a multigrid preconditioner."""
    free = ~system.held.ravel()
    matrix, preconditioner = multigrid(system)

    def solve(force: Array, tolerance: float) -> Solution:
        load = np.where(free, force.ravel(), 0.0)
        steps: list[None] = []
        with one_blas_thread():
            u, _ = cg(
                matrix,
                load,
                rtol=tolerance,
                maxiter=MAX_ITERATIONS,
                M=preconditioner,
                callback=lambda _: steps.append(None),
            )
        solution = Solution(u.reshape(-1, 3), "multigrid", len(steps), _residual(matrix, u, load))
        return _checked(solution, tolerance)

    return solve


def multigrid(system: System) -> tuple[bsr_matrix, LinearOperator]:
    """The matrix with unit rows (scaled) for held components, and one cycle of multigrid for it."""
    free = ~system.held.ravel()
    matrix = _with_unit_rows(system.matrix, free)
    with one_blas_thread():
        hierarchy = _hierarchy(system, matrix, free)
    return matrix, LinearOperator(matrix.shape, partial(_cycle, hierarchy), dtype=float)


def _cycle(hierarchy: MultilevelSolver, residual: Array, number: int = 0) -> Array:
    """One V cycle of multigrid on a level and those coarser than it: displacements for a residual.

    PyAMG's own function computes two more residuals of the finest level, which nobody reads.
    """
    level, residual = hierarchy.levels[number], residual.ravel()
    if number == len(hierarchy.levels) - 1:
        return np.asarray(hierarchy.coarse_solver(level.A, residual))
    u = np.zeros_like(residual)
    level.presmoother(level.A, u, residual)
    u += level.P @ _cycle(hierarchy, level.R @ (residual - level.A @ u), number + 1)
    level.postsmoother(level.A, u, residual)
    return u


def _hierarchy(system: System, matrix: bsr_matrix, free: Mask) -> MultilevelSolver:
    """The multigrid levels: quadratic elements, linear elements, aggregates."""
    n_vertices = system.from_vertices.shape[1]
    free_vertices = free[: 3 * n_vertices]
    to_nodes = kron(system.from_vertices, np.eye(3), format="csr")
    to_nodes = diags_array(free * 1.0) @ to_nodes @ diags_array(free_vertices * 1.0)
    coarse = (to_nodes.T.tocsr() @ matrix.tocsr() @ to_nodes).tobsr((3, 3))
    coarse = _with_unit_rows(coarse, free_vertices)
    modes = np.where(free_vertices[:, None], system.modes[: 3 * n_vertices], 0.0)
    aggregation = pyamg.smoothed_aggregation_solver(
        coarse, B=modes, strength=("symmetric", {"theta": 0.0}), improve_candidates=None
    )
    finest = MultilevelSolver.Level()
    finest.A, finest.P, finest.R = matrix, to_nodes, to_nodes.T.tocsr()
    hierarchy = MultilevelSolver([finest, *aggregation.levels], coarse_solver="pinv")
    change_smoothers(hierarchy, *SMOOTHERS)
    return hierarchy


def _with_unit_rows(matrix: bsr_matrix, free: Mask) -> bsr_matrix:
    """The matrix with held rows and columns cleared and its mean diagonal entry on their diagonal."""
    node_free = free.reshape(-1, 3)
    nodes = np.arange(len(node_free))
    row = np.repeat(nodes, np.diff(matrix.indptr))
    kept = matrix.data * (node_free[row][:, :, None] & node_free[matrix.indices][:, None, :])
    scale = float(np.mean(matrix.diagonal()))
    units = scale * ~node_free[:, :, None] * np.eye(3)
    diagonal = bsr_matrix((units, nodes, np.arange(len(nodes) + 1)), shape=matrix.shape)
    return bsr_matrix((kept, matrix.indices, matrix.indptr), shape=matrix.shape) + diagonal


def _prepare_direct(system: System) -> Callable[[Array, float], Solution]:
    """A solver by a sparse factorisation."""
    free = np.flatnonzero(~system.held.ravel())
    matrix = system.matrix.tocsr()[free][:, free]
    back_substitute = pardiso.factor(triu(matrix, format="csr"))

    def solve(force: Array, tolerance: float) -> Solution:
        load = force.ravel()[free]
        u = np.zeros(force.size)
        u[free] = back_substitute(load)
        return _checked(Solution(u.reshape(-1, 3), "direct", 0, _residual(matrix, u[free], load)), tolerance)

    return solve


def _residual(matrix: csr_matrix, u: Array, load: Array) -> float:
    """Relative residual ||f - K u|| / ||f||."""
    return float(np.linalg.norm(load - matrix @ u) / np.linalg.norm(load))


def _checked(solution: Solution, tolerance: float) -> Solution:
    """The solution; raises NotConverged where its residual is more than twice the tolerance."""
    if not solution.residual <= 2 * tolerance:
        raise NotConverged(
            f"linear solver: relative residual {solution.residual:.1e} after {solution.iterations} "
            f"iterations, {tolerance:.0e} asked for. Likely cause: strongly distorted cells or a "
            "Poisson's ratio near 0.5. Try `solver` = 'direct', or a smaller `growth`"
        )
    return solution

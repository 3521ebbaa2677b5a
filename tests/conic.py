"""Independent oracle for PMD: the paper's formulation, uncompressed, through a general conic solver."""

import clarabel
import numpy as np
from scipy import sparse


def solve_pmd(A0, A1, b0, b1, points_matrix, regularization, free_bias, w):
    """Optimum of |D(1-w)(A0 M m + beta - b)| + |D(w)(A1 M m + beta - b)| + lambda |m|, m >= 0.

    A0, A1 (K, 6, 10), b (K, 6), w (K,). Returns primal value, dual value and masses found by Clarabel, which sees
    every sample.
    """
    K, n = len(b0), points_matrix.shape[1]
    nb = 6 if free_bias else 0
    rows0 = ((1 - w)[:, None, None] * (A0 @ points_matrix)).reshape(-1, n)
    rows1 = (w[:, None, None] * (A1 @ points_matrix)).reshape(-1, n)
    rhs0, rhs1 = ((1 - w)[:, None] * b0).ravel(), (w[:, None] * b1).ravel()
    scale = np.sqrt(rhs0 @ rhs0 + rhs1 @ rhs1)
    bias0, bias1 = np.kron((1 - w)[:, None], np.eye(6))[:, :nb], np.kron(w[:, None], np.eye(6))[:, :nb]
    # variables: masses, bias, t0, t1, t2; the data are divided by |b| so that tolerances are relative to it
    N = n + nb + 3
    q = np.zeros(N)
    q[n + nb :] = 1.0, 1.0, regularization
    blocks, rhs, cones = [], [], []
    G = np.zeros((n, N))
    G[:, :n] = -np.eye(n)
    blocks.append(G)
    rhs.append(np.zeros(n))
    cones.append(clarabel.NonnegativeConeT(n))
    unit = 1.0 / scale
    parts = [(rows0, bias0, rhs0), (rows1, bias1, rhs1), (scale * np.eye(n), np.zeros((n, nb)), np.zeros(n))]
    for index, (rows, bias, right) in enumerate(parts):
        G = np.zeros((len(rows) + 1, N))
        G[0, n + nb + index] = -1.0
        G[1:, :n], G[1:, n : n + nb] = -rows * unit, -bias * unit
        blocks.append(G)
        rhs.append(np.concatenate(([0.0], -right * unit)))
        cones.append(clarabel.SecondOrderConeT(len(rows) + 1))
    q[-1] = regularization / scale  # the third norm is of the masses themselves
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((N, N)), q, sparse.csc_matrix(np.vstack(blocks)), np.concatenate(rhs), cones, settings
    )
    solution = solver.solve()
    return solution.obj_val * scale, solution.obj_val_dual * scale, np.array(solution.x[:n]), str(solution.status)

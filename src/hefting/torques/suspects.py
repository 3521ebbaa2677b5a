"""Suspects: mistakes that add columns to the equations of the torques, each fitted to the
residuals of all runs.

To first order a mistake adds X theta to the torques. X is for a delay the negative rate
of the predicted torques, for a tilted base the torques by gravity along its axes, for
joint zeros the derivatives by the angles, for gains the predicted torques of each joint,
for a payload that the controller compensates the torques of its weight, and for another
object in a part of a run the payload's ten columns there. theta is the least-squares
fit, to the residuals, of the part of X that arm, payload and nuisances, among them usual
errors of the gains, do not explain; the change of the payload's parameters follows. Rows
are averages over `INTERVAL`. Long delays are tried one by one.
"""

from collections.abc import Iterable, Iterator
from functools import cached_property

import numpy as np

from hefting.core.spatial import Array, Indices, Mask, immutable
from hefting.core.torque_moments import PAYLOAD
from hefting.torques.equations import FRICTION_BY_LOAD, OWN, RATE, Load, Rows
from hefting.torques.noise import TorqueFit
from hefting.torques.runs import TYPICAL_PAYLOAD, LoadedRuns, loads_of
from hefting.torques.samples import TorqueSamples, averages

INTERVAL = 0.1
"""[s] Time over which samples are averaged."""
PARTS = 10
"""Number of parts of a run; any consecutive ones may have another object."""
USUAL = {"delay": 0.1, "tilt": 0.1, "gains": 0.1, "zeros": 0.05, "weight": 0.5}
"""Prior standard deviations of theta [s, rad or one], for combinations that the runs do
not determine, such as a gain common to all joints."""
FEWEST_ROWS = 5
"""Fewest rows for each unknown from which suspects are fitted."""
LEAST_EVIDENCE = {
    "delay": 10.0,
    "tilt": 45.0,
    "gains": 60.0,
    "zeros": 30.0,
    "weight": 15.0,
    "part": 30.0,
}
"""Least evidence of a suspect that is believed. In 108 correct pairs of runs by two
simulators it was at most 7, 10, 48, -8, 6 and -9, except for true delays by a filter."""
LEAST_SHARE = 0.1
"""Least relative error of the payload's weight, or of its torques in a part, that is
believed: the elasticity of gears imitates 0.04."""
REVERSAL = 2
"""Number of averages on each side of a joint's reversal not used for short delays."""
DELAYS = np.linspace(-0.3, 0.3, 31), np.linspace(-0.02, 0.02, 11)
"""[s] Long delays that are tried, then differences from the best of them."""
LONG = 0.05
"""[s] Least long delay: friction that changes at once at reversals imitates one of some
10 ms, so shorter delays are fitted to first order."""
MOST_DELAYS = 4
"""Largest number of delays that are removed, one after the other."""
ANGLE = 1e-3
"""[rad] Difference of angle by which derivatives are approximated."""


@immutable
class Suspect:
    """A fitted mistake."""

    kind: str
    """``"delay"``, ``"tilt"``, ``"gains"``, ``"zeros"``, ``"weight"`` or ``"part"``"""
    loaded: bool | None
    """True if it is in the loaded runs only, None in the empty runs only, False in all"""
    theta: Array
    """(k,) by which torques are late [s], the change of gravity (3,) [m/s²], by which
    angles are too small [rad], torques too large, or the payload's weight (relative);
    for a part the ten parameters by which the object differs"""
    evidence: float
    """increase of the log likelihood, less that expected by chance (BIC)"""
    shift: Array
    """(10,) change of the payload's parameters when it is corrected"""
    part: tuple[int, float | None, float | None] | None = None
    """number of the run, begin and end of the part [s], None at those of the run"""


def without_delay(
    runs: LoadedRuns,
) -> tuple[LoadedRuns, TorqueFit, list[Suspect], Suspect | None]:
    """The runs with delays between positions and torques removed, their fit, these
    delays, and the likeliest other suspect."""
    delays: list[Suspect] = []
    while True:
        fitted = runs.fit()
        suspect = Suspects(runs, fitted).likeliest()
        if suspect is None or suspect.kind != "delay" or len(delays) == MOST_DELAYS:
            return runs, fitted, delays, suspect
        delays.append(suspect)
        runs = runs.delayed(float(suspect.theta[0]), bool(suspect.loaded))


@immutable
class _Run:
    """A run averaged over `INTERVAL`."""

    raw: TorqueSamples
    samples: TorqueSamples
    """averages of `raw`"""
    used: Mask
    """(K, n) whether a row counts"""
    columns: Array
    """(K, n, c) as `Rows.values`"""
    loaded: bool

    @property
    def inside(self) -> Array:
        """(K, n, 1) one where the torque is known for all `DELAYS`, else zero."""
        time, longest = self.samples.time, DELAYS[0][-1] + DELAYS[1][-1]
        known = (time - longest >= self.raw.time[0]) & (
            time + longest <= self.raw.time[-1]
        )
        return np.broadcast_to(known[:, None, None], (*self.used.shape, 1)) * 1.0

    def later(self, by: float) -> Array:
        """(K, n, 1) by which torques recorded `by` seconds later differ [N m]; at
        samples, as interpolation would reduce the noise."""
        raw, many = self.raw, len(self.raw.time)
        steps = round(by / raw.interval)
        if not steps:
            return np.zeros((*self.used.shape, 1))
        torque = raw.torque[np.clip(np.arange(many) + steps, 0, many - 1)]
        return averages(torque - raw.torque, self.starts)[..., None]

    @cached_property
    def starts(self) -> Indices:
        """(K,) first sample of each average."""
        return self.raw.bins(1.0 / INTERVAL)


@immutable
class Suspects:
    """The equations of all runs, linearized at their fit."""

    runs: LoadedRuns
    fit: TorqueFit

    @cached_property
    def load(self) -> Load:
        """Arm and payload of the fit."""
        return loads_of(self.runs, self.fit)

    @cached_property
    def parts(self) -> tuple[_Run, ...]:
        """All runs, the loaded ones first."""
        runs = self.runs
        parts = []
        for raw, loaded in (
            *((run, True) for run in runs.loaded),
            *((run, False) for run in runs.empty),
        ):
            mean = raw.averaged(raw.bins(1.0 / INTERVAL))
            rows = Rows.of(runs.dynamics, mean, loaded, runs.arm_known)
            rows = rows.under(runs.dynamics, self.load)
            parts.append(_Run(raw, mean, rows.used, rows.values, loaded))
        return tuple(parts)

    @cached_property
    def weights(self) -> Array:
        """(n,) inverse of the slow noise of each joint [1/(N m)]."""
        return 1.0 / np.maximum(self.fit.slow_std, 1e-9)

    def stacked(self, each: Iterable[Array]) -> Array:
        """(N, k) rows that count, whitened, run by run and joint by joint, from values
        (K, n, k) of each run."""
        pairs = zip(each, self.parts, strict=True)
        return np.concatenate(
            [np.swapaxes(x * self.weights[:, None], 0, 1)[r.used.T] for x, r in pairs]
        )

    @cached_property
    def basis(self) -> tuple[Array, Array, Array]:
        """Orthonormal U (rows, p) of the equations A x = b of samples, priors and
        calibration, the map (unknowns, p) of U'b to x, and residuals (rows,)."""
        n, own = self.runs.dynamics.joints, len(OWN)
        joints = np.concatenate([np.nonzero(r.used.T)[0] for r in self.parts])
        rows = self.stacked(r.columns for r in self.parts)
        nuisances = np.eye(n)[joints][:, :, None] * rows[:, None, :own]
        A = np.hstack((nuisances.reshape(len(rows), n * own), rows[:, own:-1]))
        prior = np.zeros((n * own, A.shape[1]))
        prior[:, : n * own] = np.diag(1.0 / self.fit.of_usual_gains.prior.T.ravel())
        matrices, torques = [A, prior], [rows[:, -1], np.zeros(len(prior))]
        if (calibration := self.runs.calibration) is not None:
            # its weight is that of averages over `INTERVAL`; the last row of a factor,
            # its residual, is left out
            std = (RATE * INTERVAL) ** 0.5 / self.weights
            factors = calibration.scales.whole.weighed(std).factors
            for j, factor in enumerate(factors[:, :-1]):
                more = np.zeros((len(factor), A.shape[1] + 1))
                more[:, j * own : (j + 1) * own] = factor[:, :own]
                more[:, n * own :] = factor[:, own:]
                matrices.append(more[:, :-1])
                torques.append(more[:, -1])
        A, b = np.vstack(matrices), np.concatenate(torques)
        lengths = np.maximum(np.sqrt((A * A).sum(axis=0)), 1e-12)
        U, S, V = np.linalg.svd(A / lengths, full_matrices=False)
        kept = S > 1e-7
        U, back = U[:, kept], (V[kept] / S[kept, None]).T / lengths[:, None]
        return U, back, b - U @ (U.T @ b)

    @cached_property
    def predicted(self) -> tuple[Array, ...]:
        """(K, n) torques of each run by the fit [N m]; the recorded ones in rows that do
        not count."""
        residuals, first = self.basis[2], 0
        predicted: list[Array] = []
        for run in self.parts:
            own = np.zeros(run.used.shape)
            count = int(run.used.sum())
            own.T[run.used.T] = residuals[first : first + count]
            first += count
            predicted.append(run.columns[..., -1] - own / self.weights)
        return tuple(predicted)

    def tried(self, rows: Array, usual: Array | float) -> tuple[Array, float, Array]:
        """theta (k,) with the prior standard deviation `usual`, evidence, and shift (10,),
        for columns `rows` (N, k)."""
        U, back, residuals = self.basis
        X = np.zeros((len(U), rows.shape[1]))
        X[: len(rows)] = rows
        explained = U.T @ X
        beyond = X - U @ explained
        prior = np.diag(np.broadcast_to(usual, X.shape[1:]) ** -2.0)
        solution = np.linalg.solve(beyond.T @ beyond + prior, beyond.T @ residuals)
        theta = np.asarray(solution, dtype=float)
        both = np.stack((residuals, residuals - beyond @ theta))
        # large friction by load is no mistake: its prior does not count
        priors = slice(len(rows), len(rows) + self.fit.prior.size)
        both[:, priors][:, FRICTION_BY_LOAD :: len(OWN)] = 0.0
        evidence = _evidence(both[0], both[1], len(rows), len(theta))
        shift = -(back @ explained @ theta)[-PAYLOAD:]
        return theta, evidence, np.asarray(shift, dtype=float)

    def by_links(self, std: Array) -> Array:
        """(10 n, 10) change of the payload's parameters by an error `std` (10 n,) of each
        parameter of the links, if these are taken from the URDF."""
        U, back, _ = self.basis
        W = self.runs.dynamics.regressor
        own = (r.samples for r in self.parts)
        X = self.stacked(W(r.position, r.velocity, r.acceleration) * std for r in own)
        return (back @ (U[: len(X)].T @ X))[-PAYLOAD:].T

    def _long_delay(self, loaded: bool) -> Suspect:
        """The best delay among `DELAYS` for all runs, or for the loaded ones."""
        U, back, residuals = self.basis
        inside = self.stacked(r.inside for r in self.parts)[:, 0] > 0.0

        def changed(by: float) -> Array:
            own = self.stacked(
                r.later(by * (r.loaded or not loaded)) for r in self.parts
            )
            return np.append(own, np.zeros(len(residuals) - len(own)))

        def remaining(by: float) -> Array:
            change = changed(by)
            kept = residuals + change - U @ (U.T @ change)
            kept[: len(inside)][~inside] = 0.0
            return kept

        by, step = 0.0, max(r.raw.interval for r in self.parts)
        for around in DELAYS:
            times = np.unique(np.round((by + around) / step)) * step
            lengths = [float(np.linalg.norm(remaining(each))) for each in times]
            by = float(times[np.argmin(lengths)])
        evidence = -np.inf
        if abs(by) > LONG:
            evidence = _evidence(remaining(0.0), remaining(by), len(inside), 1)
        shift = (back @ (U.T @ changed(by)))[-PAYLOAD:]
        return Suspect("delay", loaded, np.array([by]), evidence, shift)

    def likeliest(self) -> Suspect | None:
        """The suspect with the most evidence; None if no evidence is sufficient."""
        rows, unknowns = len(self.basis[2]), self.basis[1].shape[0]
        if self.runs.arm_known or rows < FEWEST_ROWS * unknowns:
            return None
        likely = (
            x
            for x in self.all()
            if x.evidence > LEAST_EVIDENCE[x.kind]
            and (x.kind != "weight" or abs(x.theta[0]) > LEAST_SHARE)
        )
        return max(likely, key=lambda each: each.evidence, default=None)

    def all(self) -> Iterator[Suspect]:
        """All suspects."""
        each = self._delay, self._tilt, self._gains, self._zeros, self._weight
        others = self.runs.empty or self.runs.calibration
        in_which = (False, True) if self.runs.loaded and others else (False,)
        yield from map(self._long_delay, in_which)
        for kind, of in zip(USUAL, each, strict=True):
            rows = [of(i) for i in range(len(self.parts))]
            for loaded in (*in_which, None) if kind == "weight" else in_which:
                pairs = zip(rows, self.parts, strict=True)
                X = self.stacked(
                    x * (loaded is False or r.loaded == bool(loaded)) for x, r in pairs
                )
                theta, evidence, shift = self.tried(X, USUAL[kind])
                if kind == "tilt":
                    theta = theta @ self._across
                yield Suspect(kind, loaded, theta, evidence, shift)
        for i, run in enumerate(self.parts):
            if run.loaded:
                yield from self._parts(i)

    def _delay(self, i: int) -> Array:
        """(K, n, 1) negative rate of the predicted torques of run `i`, zero near
        reversals, where friction changes at once."""
        own = self.parts[i].samples
        forth = own.velocity > 0.0
        back = np.zeros(forth.shape, dtype=bool)
        for by in range(1, REVERSAL + 1):
            other = forth[by:] != forth[:-by]
            back[by:] |= other
            back[:-by] |= other
        rate = np.gradient(self.predicted[i], own.time, axis=0)
        return np.where(back, 0.0, -rate)[..., None]

    def _gains(self, i: int) -> Array:
        return self.predicted[i][:, :, None] * np.eye(self.runs.dynamics.joints)

    def _rigid(
        self, i: int, angle: Array | float = 0.0, gravity: Array | None = None
    ) -> Array:
        """(K, n) torques of arm and payload in run `i` [N m], with `angle` [rad] added to
        the joints', or at rest under another `gravity` (3,)."""
        run, dynamics = self.parts[i], self.runs.dynamics
        own = run.samples
        dq, ddq = own.velocity, own.acceleration
        if gravity is not None:
            dynamics, dq, ddq = dynamics.under(gravity), 0.0 * dq, 0.0 * ddq
        W = dynamics.regressor(own.position + angle, dq, ddq)
        torque = W @ self.load.arm
        if run.loaded:
            torque = torque + W[..., -PAYLOAD:] @ dynamics.payload @ self.load.payload
        return torque

    def _tilt(self, i: int) -> Array:
        each = [self._rigid(i, gravity=g) for g in self._across]
        return np.stack(each, axis=-1)

    @cached_property
    def _across(self) -> Array:
        """(2, 3) vectors of gravity's magnitude, orthogonal to it [m/s²]."""
        g = self.runs.dynamics.gravity
        return np.linalg.svd(g[None])[2][1:] * float(np.linalg.norm(g))

    def _zeros(self, i: int) -> Array:
        turned = ANGLE * np.eye(self.runs.dynamics.joints)
        each = [self._rigid(i, a) - self._rigid(i, -a) for a in turned]
        return np.stack(each, axis=-1) / (2.0 * ANGLE)

    def _weight(self, i: int) -> Array:
        """(K, n, 1) torques by the payload's weight in run `i` [N m]."""
        q, dynamics = self.parts[i].samples.position, self.runs.dynamics
        W = dynamics.regressor(q, 0.0 * q, 0.0 * q)[..., -PAYLOAD:]
        return (W @ dynamics.payload @ self.load.payload)[..., None]

    def _parts(self, i: int) -> Iterator[Suspect]:
        """Suspects of another object in consecutive parts of run `i`; in all of it only
        if there is another loaded run."""
        time = self.parts[i].samples.time
        edges = np.linspace(0, len(time), PARTS + 1).astype(int)
        Y = self.parts[i].columns[..., -PAYLOAD - 1 : -1]
        several = sum(r.loaded for r in self.parts) > 1
        for a in range(PARTS):
            for b in range(a + 1, PARTS + 1):
                if b - a == PARTS and not several:
                    continue
                part = np.zeros((len(time), 1, 1))
                part[edges[a] : edges[b]] = 1.0
                each = [np.zeros((*r.used.shape, PAYLOAD)) for r in self.parts]
                each[i] = Y * part
                X = self.stacked(each)
                theta, evidence, shift = self.tried(X, TYPICAL_PAYLOAD)
                change, usual = X @ theta, X @ self.load.payload
                if np.linalg.norm(change) < LEAST_SHARE * np.linalg.norm(usual):
                    continue
                first, last = (
                    float(time[edges[k] - (k == b)] - time[0]) for k in (a, b)
                )
                span = i, first if a else None, last if b < PARTS else None
                yield Suspect("part", True, theta, evidence, shift, span)


def _evidence(before: Array, after: Array, rows: int, unknown: int) -> float:
    """Evidence (BIC) of `unknown` more parameters by the residuals without and with them;
    the correlation of neighbours reduces the effective number of the `rows`."""
    square, now = (max(float(r @ r), 1e-99) for r in (before, after))
    correlation = float(after[1:rows] @ after[: rows - 1]) / now
    many = rows
    if correlation > 0.0:
        many = rows * (1.0 - correlation) / (1.0 + correlation)
    return float(0.5 * many * np.log(square / now) - 0.5 * unknown * np.log(many))

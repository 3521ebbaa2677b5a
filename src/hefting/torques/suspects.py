"""Suspects: mistakes that add columns to the equations of the torques, each tried
beside the fit of all runs.

To first order a mistake adds X theta to the torques: a delay by theta the negative rate
of what the model predicts, a tilted base what gravity along its axes does, a joint's
zero what the torques change by with its angle, a gain the prediction itself, a payload
that the controller takes out its weight, and another object in a part of the run its
ten columns there. With the residuals r of the fit, and what arm, payload and nuisances
cannot explain of X, theta follows by least squares; and so do what is left of r, and by
how much the payload would then be another. All rows are averages over `INTERVAL`.

Long delays are beyond the first order: they are tried one by one.
"""

from collections.abc import Iterable, Iterator
from functools import cached_property

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, Mask
from hefting.core.torque_moments import PAYLOAD
from hefting.torques.equations import FRICTION_BY_LOAD, OWN, RATE, Load, Rows, columns
from hefting.torques.noise import TorqueFit
from hefting.torques.runs import TYPICAL_PAYLOAD, LoadedRuns, loads_of
from hefting.torques.samples import STICTION_SPEED, TorqueSamples, averages

INTERVAL = 0.1
"""[s] over which samples are averaged."""
PARTS = 10
"""Parts of a run, of which any that follow one another may hold another object."""
USUAL = {"delay": 0.1, "tilt": 0.1, "gains": 0.1, "zeros": 0.05, "weight": 0.5}
"""Standard deviations [s, rad or one] that keep what the runs do not tell small, as a
gain that all joints share."""
FEWEST_ROWS = 5
"""Averages for each unknown from which on what remains tells something."""
LEAST_EVIDENCE = {
    "delay": 10.0,
    "tilt": 45.0,
    "gains": 60.0,
    "zeros": 30.0,
    "weight": 15.0,
    "part": 30.0,
}
"""Evidence from which on a suspect is believed: of 60 right simulated pairs of runs it was at
most 7, 10, 48, -8 and -9, but for delays of a filter, which were there; of 48 others by
another simulator 1, -1, -14, -16 and -24; of weight of 105 it was at most 6."""
LEAST_SHARE = 0.1
"""Least share of the payload's weight that is told: gears that give pass for 0.03."""
REVERSAL = 2
"""Averages beside a joint's turning back that tell nothing of a short delay."""
DELAYS = np.linspace(-0.3, 0.3, 31), np.linspace(-0.02, 0.02, 11)
"""[s] Delays that are tried, and those about the likeliest of them."""
LONG = 0.05
"""[s] Shorter delays are left to the first order: where joints turn back, friction that
changes at once passes for one of some 10 ms."""
MOST_DELAYS = 4
"""Times that a delay is sought anew where one was taken out."""
ANGLE = 1e-3
"""[rad] by which joints are turned to see what their zeros do."""


@immutable
class Suspect:
    """A mistake, fitted."""

    kind: str
    """``"delay"``, ``"tilt"``, ``"gains"``, ``"zeros"``, ``"weight"`` or ``"part"``"""
    loaded: bool | None
    """whether it is in the runs with the payload alone; None in those without alone"""
    theta: Array
    """(k,) of a delay seconds by which torques come later, of a tilt the change of
    gravity [m/s²], of zeros what angles are too small by [rad], of gains what torques
    are too large by, and of weight what is more there, of one; of a part the ten
    parameters of what is more there"""
    evidence: float
    """Logarithm of the likelihood that it adds, less that of chance (BIC)"""
    shift: Array
    """(10,) of the payload's parameters without it"""
    part: tuple[int, float | None, float | None] | None = None
    """number of the run, and the seconds where a part of it begins and ends, None where
    the run does"""


def without_delay(
    runs: LoadedRuns,
) -> tuple[LoadedRuns, TorqueFit, list[Suspect], Suspect | None]:
    """The runs and their fit, with positions and torques by one clock; the delays that
    were taken out for it; and what else is suspect."""
    delays: list[Suspect] = []
    while True:
        found = runs.fit()
        suspect = Suspects(runs, found).likeliest()
        if suspect is None or suspect.kind != "delay" or len(delays) == MOST_DELAYS:
            return runs, found, delays, suspect
        delays.append(suspect)
        runs = runs.delayed(float(suspect.theta[0]), bool(suspect.loaded))


@immutable
class _Run:
    """A run in averages."""

    raw: TorqueSamples
    samples: TorqueSamples
    """averages of `raw`"""
    used: Mask
    """(K, n)"""
    columns: Array
    """(K, n, c) as of `equations.columns`"""
    loaded: bool

    @property
    def inside(self) -> Array:
        """(K, n, 1) one where the torque is known at any of `DELAYS`."""
        time, longest = self.samples.time, DELAYS[0][-1] + DELAYS[1][-1]
        known = (time - longest >= self.raw.time[0]) & (
            time + longest <= self.raw.time[-1]
        )
        return np.broadcast_to(known[:, None, None], (*self.used.shape, 1)) * 1.0

    def later(self, by: float) -> Array:
        """(K, n, 1) torques [N m], less those of a known arm, that come `by` seconds
        later, to a sample: between samples the noise would be smaller."""
        raw, many = self.raw, len(self.raw.time)
        steps = round(by / raw.interval)
        torque = raw.torque[np.clip(np.arange(many) + steps, 0, many - 1)]
        change = averages(torque - raw.torque, self.starts)
        return self.columns[..., -1:] + change[..., None]

    @cached_property
    def starts(self) -> Indices:
        """(K,) first sample of each average."""
        return self.raw.bins(1.0 / INTERVAL)


@immutable
class Suspects:
    """The equations of all runs, at the fit."""

    runs: LoadedRuns
    fit: TorqueFit

    @cached_property
    def load(self) -> Load:
        """Arm and payload as found."""
        return loads_of(self.runs, self.fit)

    @cached_property
    def parts(self) -> tuple[_Run, ...]:
        """All runs, the loaded ones first."""
        runs = self.runs
        found = []
        for samples, loaded in (
            *((own, True) for own in runs.loaded),
            *((own, False) for own in runs.empty),
        ):
            few = samples.averaged(samples.bins(1.0 / INTERVAL))
            used = np.abs(few.velocity) >= STICTION_SPEED
            values, published = columns(runs.dynamics, few, loaded, runs.arm_known)
            rows = Rows(
                values, few.time, used, published if runs.arm_known else None
            ).under(runs.dynamics, self.load)
            found.append(_Run(samples, few, used, rows.values, loaded))
        return tuple(found)

    @cached_property
    def weights(self) -> Array:
        """(n,) one over the slow noise of each joint."""
        return 1.0 / np.maximum(self.fit.slow_std, 1e-9)

    def stacked(self, each: Iterable[Array]) -> Array:
        """(N, k) rows that count of all runs, joint by joint, whitened, from (K, n, k)
        of each."""
        pairs = zip(each, self.parts, strict=True)
        return np.concatenate(
            [np.swapaxes(x * self.weights[:, None], 0, 1)[r.used.T] for x, r in pairs]
        )

    @cached_property
    def basis(self) -> tuple[Array, Array, Array]:
        """(rows, p) orthonormal U of all columns and priors, (p, p) map of U'b to the
        unknowns, and (rows,) residuals."""
        n, own = self.runs.dynamics.joints, len(OWN)
        joints = np.concatenate([np.nonzero(r.used.T)[0] for r in self.parts])
        all_of = self.stacked(r.columns for r in self.parts)
        alone = (np.eye(n)[joints][:, :, None] * all_of[:, None, :own]).reshape(
            len(all_of), -1
        )
        A = np.hstack((alone, all_of[:, own:-1]))
        b = all_of[:, -1]
        prior = np.zeros((n * own, A.shape[1]))
        prior[:, : n * own] = np.diag(1.0 / self.fit.prior.T.ravel())
        more = [prior]
        if (known := self.runs.calibration) is not None:
            # as many rows as averages; the last of a factor is what nothing explains
            less = (RATE * INTERVAL) ** 0.5
            factors = known.scales.whole.weighed(less / self.weights).factors
            for j, factor in enumerate(factors[:, :-1]):
                rows = np.zeros((len(factor), A.shape[1] + 1))
                rows[:, j * own : (j + 1) * own] = factor[:, :own]
                rows[:, n * own :] = factor[:, own:]
                more.append(rows[:, :-1])
                b = np.append(b, rows[:, -1])
        # priors come first among what is added, and have no torque
        count = len(all_of)
        b = np.concatenate((b[:count], np.zeros(len(prior)), b[count:]))
        A = np.vstack((A, *more))
        lengths = np.maximum(np.sqrt((A * A).sum(axis=0)), 1e-12)
        U, S, V = np.linalg.svd(A / lengths, full_matrices=False)
        kept = S > 1e-7
        U, back = U[:, kept], (V[kept] / S[kept, None]).T / lengths[:, None]
        return U, back, b - U @ (U.T @ b)

    @cached_property
    def predicted(self) -> tuple[Array, ...]:
        """(K, n) torques of each run by the fit [N m]."""
        left, first = self.basis[2], 0
        found: list[Array] = []
        for run in self.parts:
            own = np.zeros(run.used.shape)
            count = int(run.used.sum())
            own.T[run.used.T] = left[first : first + count]
            first += count
            found.append(run.columns[..., -1] - own / self.weights)
        return tuple(found)

    def tried(self, rows: Array, usual: Array | float) -> tuple[Array, float, Array]:
        """theta (k,) of about the size `usual`, evidence, and shift (10,), of columns
        (N, k)."""
        U, back, left = self.basis
        X = np.zeros((len(U), rows.shape[1]))
        X[: len(rows)] = rows
        inside = U.T @ X
        beside = X - U @ inside
        prior = np.diag(np.broadcast_to(1.0 / usual, X.shape[1:]))
        found = np.linalg.lstsq(
            np.vstack((beside, prior)), np.append(left, np.zeros(len(prior)))
        )[0]
        theta = np.asarray(found, dtype=float)
        both = np.stack((left, left - beside @ theta))
        # friction by load that is more than usual is no mistake
        priors = slice(len(rows), len(rows) + self.fit.prior.size)
        both[:, priors][:, FRICTION_BY_LOAD :: len(OWN)] = 0.0
        evidence = _evidence(both[0], both[1], len(rows), len(theta))
        shift = -(back @ inside @ theta)[-PAYLOAD:]
        return theta, evidence, np.asarray(shift, dtype=float)

    def by_links(self, std: Array) -> Array:
        """(10 n, 10) change of the payload's parameters by `std` (10 n,) of each of the
        links' parameters, where the URDF's are taken for the arm's."""
        U, back, _ = self.basis
        W = self.runs.dynamics.regressor
        own = (r.samples for r in self.parts)
        X = self.stacked(W(r.position, r.velocity, r.acceleration) * std for r in own)
        return (back @ (U[: len(X)].T @ X))[-PAYLOAD:].T

    def _long_delay(self, loaded: bool) -> Suspect:
        """Torques of all runs, or of the loaded ones, that come later by one time."""
        U, back, left = self.basis
        torque = self.stacked(r.columns[..., -1:] for r in self.parts)[:, 0]
        inside = self.stacked(r.inside for r in self.parts)[:, 0] > 0.0

        def changed(by: float) -> Array:
            own = self.stacked(
                r.later(by * (r.loaded or not loaded)) for r in self.parts
            )
            return np.append(own[:, 0] - torque, np.zeros(len(left) - len(torque)))

        def remaining(by: float) -> Array:
            more = changed(by)
            kept = left + more - U @ (U.T @ more)
            kept[: len(torque)][~inside] = 0.0
            return kept

        by, step = 0.0, max(r.raw.interval for r in self.parts)
        for around in DELAYS:
            times = np.unique(np.round((by + around) / step)) * step
            lengths = [float(np.linalg.norm(remaining(each))) for each in times]
            by = float(times[np.argmin(lengths)])
        evidence = -np.inf
        if abs(by) > LONG:
            evidence = _evidence(remaining(0.0), remaining(by), len(torque), 1)
        shift = (back @ (U.T @ changed(by)))[-PAYLOAD:]
        return Suspect("delay", loaded, np.array([by]), evidence, shift)

    def likeliest(self) -> Suspect | None:
        """The suspect with the most evidence, where it is enough."""
        rows, unknown = len(self.basis[2]), self.basis[1].shape[0]
        if self.runs.arm_known or rows < FEWEST_ROWS * unknown:
            return None
        told = (x for x in self.all() if x.evidence > LEAST_EVIDENCE[x.kind])
        told = (x for x in told if x.kind != "weight" or abs(x.theta[0]) > LEAST_SHARE)
        return max(told, key=lambda each: each.evidence, default=None)

    def all(self) -> Iterator[Suspect]:
        """Each suspect, fitted."""
        kinds = {"delay": self._short_delay, "tilt": self._tilt, "gains": self._gains}
        kinds["zeros"], kinds["weight"] = self._zeros, self._weight
        others = self.runs.empty or self.runs.calibration
        in_which = (False, True) if self.runs.loaded and others else (False,)
        yield from map(self._long_delay, in_which)
        for kind, of in kinds.items():
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

    def _short_delay(self, i: int) -> Array:
        """Zero where a joint turns back, as friction then changes at once."""
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
        """(K, n) torques of arm and payload in a run [N m], with angles off by `angle`,
        or at rest by gravity (3,) alone."""
        run, dynamics = self.parts[i], self.runs.dynamics
        own = run.samples
        dq, ddq = own.velocity, own.acceleration
        if gravity is not None:
            dynamics, dq, ddq = dynamics.under(gravity), 0.0 * dq, 0.0 * ddq
        W = dynamics.regressor(own.position + angle, dq, ddq)
        found = W @ self.load.arm
        if run.loaded:
            found = found + W[..., -PAYLOAD:] @ dynamics.payload @ self.load.payload
        return found

    def _tilt(self, i: int) -> Array:
        each = [self._rigid(i, gravity=g) for g in self._across]
        return np.stack(each, axis=-1)

    @cached_property
    def _across(self) -> Array:
        """(2, 3) gravity along the axes that lie across it [m/s²]."""
        g = self.runs.dynamics.gravity
        return np.linalg.svd(g[None])[2][1:] * float(np.linalg.norm(g))

    def _zeros(self, i: int) -> Array:
        turned = ANGLE * np.eye(self.runs.dynamics.joints)
        each = [self._rigid(i, a) - self._rigid(i, -a) for a in turned]
        return np.stack(each, axis=-1) / (2.0 * ANGLE)

    def _weight(self, i: int) -> Array:
        """What the payload's weight alone needs."""
        q, dynamics = self.parts[i].samples.position, self.runs.dynamics
        W = dynamics.regressor(q, 0.0 * q, 0.0 * q)[..., -PAYLOAD:]
        return (W @ dynamics.payload @ self.load.payload)[..., None]

    def _parts(self, i: int) -> Iterator[Suspect]:
        """Another object in any stretch of whole parts of run `i`; in all of it only
        beside another loaded run."""
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
                first, last = (
                    float(time[edges[k] - (k == b)] - time[0]) for k in (a, b)
                )
                span = i, first if a else None, last if b < PARTS else None
                yield Suspect("part", True, theta, evidence, shift, span)


def _evidence(before: Array, after: Array, rows: int, unknown: int) -> float:
    """Of residuals that `unknown` more parameters made smaller, by `rows` rows whose
    neighbours are alike."""
    square, now = (max(float(r @ r), 1e-99) for r in (before, after))
    alike = float(after[1:rows] @ after[: rows - 1]) / now
    many = rows * (1.0 - alike) / (1.0 + alike) if alike > 0.0 else rows
    return float(0.5 * many * np.log(square / now) - 0.5 * unknown * np.log(many))

"""python3 benches/contacts/fclib_test.py: a problem made by hand, as FCLIB writes it, and what fclib.py makes of it."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from fclib import Problem, cross  # noqa: E402

SCRIPT = Path(__file__).with_name("fclib.py")


def turn(seed):
    """A rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def write_matrix(group, matrix, kind):
    """As triplets, compressed columns (-1) or compressed rows (-2)."""
    rows, columns = np.nonzero(matrix)
    if kind == -1:
        columns, rows = np.nonzero(matrix.T)
    x = matrix[rows, columns]
    outer, inner = (columns, rows) if kind != -2 else (rows, columns)
    size = matrix.shape[0] if kind == -2 else matrix.shape[1]
    p = columns if kind >= 0 else np.searchsorted(outer, np.arange(size + 1))
    values = {"m": [matrix.shape[0]], "n": [matrix.shape[1]], "nz": [len(x) if kind >= 0 else kind], "nzmax": [len(x)]}
    for name, value in {**values, "p": p, "i": rows if kind >= 0 else inner, "x": x}.items():
        group[name] = np.asarray(value, dtype=float if name == "x" else "i4")


class ByHand(unittest.TestCase):
    """Two bodies, angular velocities in axes of their own: one on the ground, the other on it, a row of a joint between."""

    def setUp(self):
        self.turns = [turn(1), turn(2)]
        self.inertias = [np.diag([1.0, 2.0, 3.0]), np.diag([0.5, 0.7, 0.4])]
        self.mass = np.zeros((12, 12))
        for k, (mass, inertia) in enumerate(zip((2.0, 0.5), self.inertias)):
            self.mass[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = mass * np.eye(3)
            self.mass[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = inertia
        self.contacts = [
            ([None, 0], [None, np.array([0.3, -0.5, 0.1])], turn(3)),
            ([None, 0], [None, np.array([-0.3, -0.5, 0.2])], turn(4)),
            ([0, 1], [np.array([0.0, 0.5, 0.1]), np.array([0.1, -0.4, 0.0])], turn(5)),
        ]
        self.h = np.zeros((12, 9))
        for k, (ends, arms, frame) in enumerate(self.contacts):
            for body, arm, sign in zip(ends, arms, (-1, 1)):
                if body is not None:
                    self.h[6 * body : 6 * body + 3, 3 * k : 3 * k + 3] = sign * frame
                    moment = sign * self.turns[body].T @ cross(arm) @ frame
                    self.h[6 * body + 3 : 6 * body + 6, 3 * k : 3 * k + 3] = moment
        self.g = np.random.default_rng(6).standard_normal((12, 1))

    def write(self, path, kind=0, h=None):
        with h5py.File(path, "w") as file:
            group = file.create_group("fclib_global")
            group["spacedim"] = np.array([3], dtype="i4")
            for name, matrix in (("M", self.mass), ("H", self.h if h is None else h), ("G", self.g)):
                write_matrix(group.create_group(name), matrix, kind)
            random = np.random.default_rng(7)
            for name, count in (("f", 12), ("w", 9), ("b", 1)):
                group[f"vectors/{name}"] = random.standard_normal(count)
            group["vectors/mu"] = np.array([0.3, 0.5, 0.7])

    def test_bodies_arms_and_normals_are_found_again(self):
        with tempfile.TemporaryDirectory() as folder:
            for kind in (0, -1, -2):
                path = Path(folder, f"by_hand{kind}.hdf5")
                self.write(path, kind)
                with h5py.File(path) as file:
                    problem = Problem(file)
                self.assertLess(problem.off(), 1e-12)
                _, contacts, joints = problem.given()
                self.assertEqual(len(joints), 1)
                for (ends, arms, normal, *_), (own_ends, own_arms, frame) in zip(contacts, self.contacts):
                    self.assertEqual(ends, own_ends)
                    self.assertLess(np.abs(normal - frame[:, 0]).max(), 1e-12)
                    for arm, own in zip(arms, own_arms):
                        if own is not None:
                            # About axes that the body's own turn is told by up to a half turn.
                            self.assertAlmostEqual(np.linalg.norm(arm), np.linalg.norm(own), 12)

    def test_what_is_not_rigid_is_refused_with_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            crooked, twisted = self.h.copy(), self.h.copy()
            crooked[0, 1] += 0.1
            twisted[3, 0] += 0.1
            for name, h in (("crooked", crooked), ("twisted", twisted)):
                path = Path(folder, f"{name}.hdf5")
                self.write(path, h=h)
                done = subprocess.run([sys.executable, SCRIPT, path, "--out", folder], capture_output=True, text=True)
                self.assertEqual(done.returncode, 2)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(f"{name}.hdf5: has a", done.stderr)
                self.assertFalse(path.with_suffix(".txt").exists())


if __name__ == "__main__":
    unittest.main()

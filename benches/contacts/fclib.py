"""FCLIB's contact problems (https://github.com/FrictionalContactLibrary) as problems of the benchmark `contacts`.

python3 benches/contacts/fclib.py FILE.hdf5 [...] --out DIR

Needs h5py and numpy. Takes global problems of rigid bodies in three dimensions,

    M v = H r + f,  u = Hᵀ v + w,  joints: Gᵀ v + b = 0,  K* ∋ u + μ|u_t| n ⊥ r ∈ K,

with six coordinates a body: M by bodies, isotropic for the linear velocity, and H by contacts of at most two bodies whose
points move with them. Angular coordinates may be in each body's own axes: which turn they stand for is found from H, up to what
makes no difference. Whatever is no such problem (deformable bodies, rolling friction, local problems, of which only the Delassus
matrix is known and not the bodies) is refused with one line and exit status 2; the others are written all the same.

Every problem is checked before it is written: for random r, the u of what is written is that of M, H, f and w.
"""

import argparse
import sys
from pathlib import Path

import h5py
import numpy as np

HEADER = "plumb contact problem 1"
# Relative size of what may be rounding in H and M.
ROUNDED = 1e-6


class NotSuch(Exception):
    """What a file is instead."""


def matrix(group):
    """A dense matrix of one of FCLIB's sparse ones: triplets, compressed columns or compressed rows."""
    rows, columns, kind = (int(group[name][0]) for name in ("m", "n", "nz"))
    p, i, x = (np.asarray(group[name]) for name in ("p", "i", "x"))
    dense = np.zeros((rows, columns))
    if kind >= 0:
        places = (i[:kind], p[:kind])
        x = x[:kind]
    else:
        count = int(p[-1])
        outer = np.repeat(np.arange(len(p) - 1), np.diff(p))
        places = (i[:count], outer) if kind == -1 else (outer, i[:count])
        x = x[:count]
    np.add.at(dense, places, x)
    return dense


def cross(a):
    """The matrix of a × ."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def arm_of(skew):
    return 0.5 * np.array([skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1]])


def turns(moment):
    """The turns R for which moment = −[a]× R for some a: two, or any where there is no moment."""
    u, s, vt = np.linalg.svd(moment)
    if s[0] == 0.0:
        return [np.eye(3)]
    # [a]× R keeps the plane across Rᵀa, turned by 90°: singular values |a|, |a|, 0.
    axis = np.cross(u[:, 0], u[:, 1])
    found = []
    for sign in (1, -1):
        # −[a]× (R v) = s u for a = sign |a| axis.
        images = [sign * np.cross(axis, u[:, k]) for k in (0, 1)]
        left = np.column_stack(images + [np.cross(*images)])
        right = np.column_stack([vt[0], vt[1], np.cross(vt[0], vt[1])])
        found.append(left @ right.T)
    return found


class Problem:
    """Bodies, contacts and joints of a global problem, of which there is at least one contact."""

    def __init__(self, file):
        if "fclib_global" not in file:
            kinds = ", ".join(name for name in file if name.startswith("fclib"))
            raise NotSuch(f"has {kinds or 'no problem'}, not fclib_global: its bodies are not known")
        group = file["fclib_global"]
        if int(group["spacedim"][0]) != 3:
            raise NotSuch("is not of three dimensions")
        mass, to_contacts = matrix(group["M"]), matrix(group["H"])
        if len(mass) % 6 or to_contacts.shape[1] % 3:
            raise NotSuch(f"has {len(mass)} coordinates; bodies have six each")
        vectors = group["vectors"]
        self.count = len(mass) // 6
        self.force, self.free_u = np.asarray(vectors["f"]), np.asarray(vectors["w"])
        self.friction = np.asarray(vectors["mu"])
        self.blocks = [mass[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] for k in range(self.count)]
        whole = np.zeros_like(mass)
        for k, block in enumerate(self.blocks):
            whole[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = block
            coupled = max(np.abs(block[:3, 3:]).max(), np.abs(block[:3, :3] - block[0, 0] * np.eye(3)).max())
            if coupled > ROUNDED * block[0, 0]:
                raise NotSuch(f"has a body {k} whose mass is no number times the identity: it is not rigid")
        if np.abs(mass - whole).max() > ROUNDED * np.abs(mass).max():
            raise NotSuch("has masses between bodies: they are not rigid")
        self.h = to_contacts
        self.contacts = [self.contact(k) for k in range(to_contacts.shape[1] // 3)]
        self.g = matrix(group["G"]) if "G" in group else np.zeros((len(mass), 0))
        self.free_g = np.asarray(vectors["b"]) if "G" in group else np.zeros(0)
        self.turn = [self.turn_of(k) for k in range(self.count)]

    def contact(self, index):
        """Its frame (columns n, t₁, t₂) and [(body, sign, moment)]: Jᵀ of each body is sign [F; moment·F] by columns of H."""
        rows = self.h[:, 3 * index : 3 * index + 3]
        bodies = sorted({row // 6 for row in np.nonzero(np.abs(rows).max(axis=1) > 0)[0]})
        if not 1 <= len(bodies) <= 2:
            raise NotSuch(f"has a contact {index} of {len(bodies)} bodies")
        frame, sides = None, []
        for body in bodies:
            linear, angular = rows[6 * body : 6 * body + 3], rows[6 * body + 3 : 6 * body + 6]
            if frame is None:
                # With one body, or the second of two, the normal is towards it.
                frame = linear if len(bodies) == 1 else -linear
                if np.abs(frame.T @ frame - np.eye(3)).max() > ROUNDED:
                    raise NotSuch(f"has a contact {index} whose axes are not orthonormal: it is none of rigid bodies")
            sign = 1.0 if np.abs(linear - frame).max() <= ROUNDED else -1.0
            if np.abs(linear - sign * frame).max() > ROUNDED:
                raise NotSuch(f"has a contact {index} that moves with its bodies otherwise than as a point")
            # u = sign Fᵀ(v − [a]× R ω') : the part of ω' is (angular)ᵀ.
            sides.append((body, sign, sign * frame @ angular.T))
        return frame, sides

    def turn_of(self, body):
        """R with which all moments of the body's contacts are −[a]× R."""
        moments = [moment for _, sides in self.contacts for other, _, moment in sides if other == body]
        moments.sort(key=lambda moment: -np.abs(moment).max())
        if not moments:
            return np.eye(3)

        def worst(turn):
            return max(np.abs(moment @ turn.T + (moment @ turn.T).T).max() for moment in moments)

        best = min([np.eye(3)] + turns(moments[0]), key=worst)
        if worst(best) > ROUNDED * np.abs(moments[0]).max():
            raise NotSuch(f"has a body {body} whose contacts have no arms in common axes: it is not rigid")
        return best

    def given(self):
        """What is written of bodies, contacts and joints."""
        bodies = []
        for k, (block, turn) in enumerate(zip(self.blocks, self.turn)):
            free = np.linalg.solve(block, self.force[6 * k : 6 * k + 6])
            inertia = turn @ np.linalg.inv(block[3:, 3:]) @ turn.T
            inertia = 0.5 * (inertia + inertia.T)
            bodies.append((np.full(3, 1.0 / block[0, 0]), inertia, free[:3], turn @ free[3:]))
        contacts = []
        for k, (frame, sides) in enumerate(self.contacts):
            ends, arms = [None, None], [np.zeros(3), np.zeros(3)]
            for body, sign, moment in sides:
                side = 1 if sign > 0 else 0
                ends[side], arms[side] = body, -arm_of(moment @ self.turn[body].T)
            contacts.append((ends, arms, frame[:, 0], self.friction[k], frame @ self.free_u[3 * k : 3 * k + 3]))
        joints = []
        for k in range(self.g.shape[1]):
            row = self.g[:, k]
            ends = sorted({place // 6 for place in np.nonzero(row)[0]})
            if not 1 <= len(ends) <= 2:
                raise NotSuch(f"has a row {k} of joints of {len(ends)} bodies")
            jacobians = []
            for body in ends:
                own = np.zeros((3, 6))
                own[0, :3] = row[6 * body : 6 * body + 3]
                own[0, 3:] = self.turn[body] @ row[6 * body + 3 : 6 * body + 6]
                jacobians.append(own)
            ends, jacobians = ([None] + ends, [np.zeros((3, 6))] + jacobians) if len(ends) == 1 else (ends, jacobians)
            joints.append((ends, jacobians, np.array([self.free_g[k], 0, 0])))
        return bodies, contacts, joints

    def text(self, comment):
        bodies, contacts, joints = self.given()
        lines = [HEADER, f"# {comment}", f"bodies {len(bodies)}"]
        lines += [row(*body) for body in bodies]
        lines.append(f"contacts {len(contacts)}")
        for ends, arms, normal, friction, bias in contacts:
            lines.append(row(*ends, *arms, normal, friction, bias, np.zeros(3)))
        lines.append(f"joints {len(joints)}")
        for ends, jacobians, bias in joints:
            lines.append(row(*ends, *jacobians, -np.inf, np.inf, bias, np.zeros(3)))
        return "\n".join(lines) + "\n"

    def off(self):
        """How far the u of what is written, for random r, is from that of M, H, f and w, over the largest u."""
        bodies, contacts, joints = self.given()
        random = np.random.default_rng(1)
        r, s = random.standard_normal(3 * len(contacts)), random.standard_normal(len(joints))
        pushed = self.force + self.h @ r + self.g @ s
        v = np.concatenate([np.linalg.solve(m, pushed[6 * k : 6 * k + 6]) for k, m in enumerate(self.blocks)])
        wanted = np.concatenate([self.h.T @ v + self.free_u, self.g.T @ v + self.free_g])

        # Everything as a row of J: its ends, its Jacobians, its axes, its bias.
        points = []
        for (ends, arms, _, _, bias), (frame, _) in zip(contacts, self.contacts):
            jacobians = [sign * np.hstack([np.eye(3), -cross(arm)]) for arm, sign in zip(arms, (-1, 1))]
            points.append((ends, jacobians, frame, bias))
        points += [(ends, jacobians, np.eye(3)[:, :1], bias) for ends, jacobians, bias in joints]
        velocities = [np.concatenate(body[2:]) for body in bodies]
        multipliers = [r[3 * k : 3 * k + 3] for k in range(len(contacts))] + [s[k : k + 1] for k in range(len(joints))]
        for (ends, jacobians, axes, _), multiplier in zip(points, multipliers):
            for body, jacobian in zip(ends, jacobians):
                if body is not None:
                    wrench = jacobian.T @ axes @ multiplier
                    velocities[body] += np.concatenate([bodies[body][0] * wrench[:3], bodies[body][1] @ wrench[3:]])
        found = []
        for ends, jacobians, axes, bias in points:
            moved = sum(jacobian @ velocities[body] for body, jacobian in zip(ends, jacobians) if body is not None)
            found.append(axes.T @ (bias + moved))
        return np.abs(np.concatenate(found) - wanted).max() / np.abs(wanted).max()


def row(*values):
    """Numbers of a line; matrices column by column, with as many digits as it takes."""
    words = []
    for value in values:
        if value is None:
            words.append("-")
        elif isinstance(value, (int, np.integer)):
            words.append(str(value))
        else:
            words += [repr(float(number)) for number in np.asarray(value).flatten(order="F")]
    return " ".join(words)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.hdf5")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the problems")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    refused = False
    for path in arguments.files:
        try:
            with h5py.File(path) as file:
                problem = Problem(file)
                off = problem.off()
                if off > ROUNDED:
                    raise NotSuch(f"comes out otherwise, by {off:.1e} of the largest velocity: it is not rigid")
                text = problem.text(f"FCLIB, {path.name}")
        except (NotSuch, OSError, KeyError) as error:
            refused = True
            print(f"fclib.py: {path}: {error}", file=sys.stderr)
            continue
        (arguments.out / f"{path.stem}.txt").write_text(text)
    return 2 if refused else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""MuJoCo on the scenes of hinges in series: `arm` and `hinge_chain`.

Writes rows with the columns of `peers ... --out DIR` to DIR/mujoco_joints.csv. Needs MuJoCo: `pip install mujoco`.
In minimal coordinates hinges neither part nor tilt; what is left to measure is the energy of a chain, how far it goes
beyond its limits, which are soft, and the tip and the torques of the arm.

MuJoCo has no motors that follow a motion. It has inverse dynamics: the torques that the motion takes, by `mj_inverse`,
are what `torque_error` compares, and applying over each step those of its middle is what moves the arm. A step of `arm`
is both.
"""

import argparse
import csv
import math
import pathlib
import statistics
import sys
import time

import mujoco
import numpy as np

from mujoco_rods import COLUMNS, INTEGRATORS, REFERENCE, box_moments, unstable

RATES = (60, 240, 1000)
EARTH = 9.81
# Where from the one before, axis, amplitude, angular frequency of A (1 − cos ωt); centre, mass and size of the box.
ARM = (
    ((0, 0, 0), (0, 1, 0), 0.8, 2.0, (0, 0.25, 0), 5.0, (0.2, 0.5, 0.2)),
    ((0, 0.5, 0), (0, 0, 1), 0.5, 3.0, (0.3, 0, 0), 2.0, (0.6, 0.1, 0.1)),
    ((0.6, 0, 0), (0, 0, 1), -0.7, 4.0, (0.25, 0, 0), 1.0, (0.5, 0.08, 0.08)),
)
# Torques are compared from then on, s, as by `peers`.
FIRST = 0.05


def words(numbers):
    return " ".join(f"{number:.17g}" for number in numbers)


def body(at, axis, center, mass, moments, inner, limit=0.0):
    """A body on a hinge at `at` of its parent, its centre of mass at `center` from there."""
    limited = f' limited="true" range="{-limit:.17g} {limit:.17g}"' if limit else ""
    return (
        f'<body pos="{words(at)}"><joint type="hinge" axis="{words(axis)}"{limited}/>'
        f'<inertial pos="{words(center)}" mass="{mass}" diaginertia="{words(moments)}"/>{inner}</body>'
    )


def arm():
    inner = '<site name="tip" pos="0.5 0 0"/>'
    for at, axis, _, _, center, mass, size in reversed(ARM):
        inner = body(at, axis, center, mass, box_moments(mass, *size), inner)
    return inner


def hinge_chain(links, ball, limit):
    """Boxes 0.2 × 0.1 × 0.1 m of 1 kg along +x, then a ball of radius 0.3 m and that mass."""
    inner = body((0.2, 0, 0), (0, 0, 1), (0.3, 0, 0), ball, [0.4 * ball * 0.09] * 3, "", limit)
    for link in reversed(range(links)):
        at = (0.2 if link else 0, 0, 0)
        inner = body(at, (0, 0, 1), (0.1, 0, 0), 1, box_moments(1, 0.2, 0.1, 0.1), inner, limit)
    return inner


def model_of(bodies, gravity, integrator, hz, energy):
    energy = "enable" if energy else "disable"
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="{words(gravity)}" timestep="{1 / hz:.17g}"'
        f' integrator="{integrator}"><flag contact="disable" energy="{energy}"/></option>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )


def motion(instant):
    """Angles of the arm, their rates and accelerations."""
    a = np.array([link[2] for link in ARM])
    w = np.array([link[3] for link in ARM])
    return a * (1 - np.cos(w * instant)), a * w * np.sin(w * instant), a * w * w * np.cos(w * instant)


def torques(model, data, instant):
    data.qpos[:], data.qvel[:], data.qacc[:] = motion(instant)
    mujoco.mj_inverse(model, data)
    return data.qfrc_inverse.copy()


def measure_arm(integrator, hz, rounds, seconds):
    with open(REFERENCE / "arm.csv", encoding="utf-8", newline="") as table:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]
    rows = [row for row in rows if row["t"] <= seconds]
    model = model_of(arm(), (0, -EARTH, 0), integrator, hz, energy=False)
    inverse = mujoco.MjData(model)
    torque_error = max(
        float(np.abs(torques(model, inverse, row["t"]) - [row[f"torque{hinge}"] for hinge in (1, 2, 3)]).max())
        for row in rows
        if row["t"] >= FIRST
    )
    milliseconds, error = [], 0.0
    steps = round(seconds * hz)
    for _ in range(rounds):
        data = mujoco.MjData(model)
        tips, took = {}, 0.0
        for step in range(steps):
            begin = time.perf_counter()
            data.qfrc_applied[:] = torques(model, inverse, (step + 0.5) / hz)
            mujoco.mj_step(model, data)
            took += time.perf_counter() - begin
            tips[step + 1] = data.qpos.copy()
        milliseconds.append(1e3 * took / steps)
    for row in rows[1:]:
        data.qpos[:] = tips[round(row["t"] * hz)]
        mujoco.mj_kinematics(model, data)
        tip = data.site("tip").xpos
        error = max(error, float(np.linalg.norm(tip - [row["tip_x"], row["tip_y"], row["tip_z"]])))
    known = dict(answer="tip of the forearm", error=error, unit="m", torque_error=torque_error)
    return known, milliseconds


def measure_chain(integrator, hz, rounds, seconds, ball, limit):
    pull = 10 / math.sqrt(2)
    bodies = hinge_chain(100, ball, math.radians(limit))
    milliseconds = []
    for _ in range(rounds):
        model = model_of(bodies, (0, -pull, -pull), integrator, hz, energy=False)
        data = mujoco.MjData(model)
        steps = round(seconds * hz)
        begin = time.perf_counter()
        mujoco.mj_step(model, data, steps)
        milliseconds.append(1e3 * (time.perf_counter() - begin) / steps)
    model = model_of(bodies, (0, -pull, -pull), integrator, hz, energy=True)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start, drift, kinetic, overshoot = data.energy.sum(), 0.0, 0.0, 0.0
    for _ in range(round(seconds * hz)):
        mujoco.mj_step(model, data)
        if unstable(data):
            return dict(note="unstable: MuJoCo starts again"), milliseconds
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        change = data.energy.sum() - start
        drift, kinetic = max(drift, abs(change)), max(kinetic, data.energy[1])
        if limit:
            overshoot = max(overshoot, float(np.abs(data.qpos).max()) - math.radians(limit))
    known = dict(joint_separation=0.0, joint_separation_end=0.0, hinge_tilt=0.0)
    known |= dict(energy_change=change / kinetic, energy_drift=drift / kinetic)
    return known | (dict(limit_overshoot=overshoot) if limit else {}), milliseconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, help="also write DIR/mujoco_joints.csv")
    parser.add_argument("--rounds", type=int, default=3, help="how often each run is timed")
    parser.add_argument("--seconds", type=float, default=10, help="time to simulate chains; the arm has 2 s")
    arguments = parser.parse_args()
    mujoco.set_mju_user_warning(lambda _: None)
    chains = [("hinge_chain", f"n=100 r={r} limit={limit}", r, limit) for r, limit in ((1, 0), (1000, 0), (1, 45))]
    scenes = [("arm", "", 2.0, lambda *run: measure_arm(*run, 2.0))]
    for name, parameters, ball, limit in chains:
        run = lambda *run, ball=ball, limit=limit: measure_chain(*run, arguments.seconds, ball, limit)
        scenes.append((name, parameters, arguments.seconds, run))
    rows = []
    print(f"mujoco {mujoco.__version__}, f64, 1 thread")
    for name, parameters, seconds, measure in scenes:
        for integrator, engine in INTEGRATORS.items():
            for hz in RATES:
                known, milliseconds = measure(integrator, hz, arguments.rounds)
                median = statistics.median(milliseconds)
                rows.append(
                    dict(
                        run="accuracy", scene=name, parameters=parameters, engine=engine, version=mujoco.__version__,
                        precision="f64", hz=float(hz), substeps=1, iterations=1, threads=1, seconds=float(seconds),
                        ms_per_step=median, ms_low=min(milliseconds), ms_high=max(milliseconds),
                    )
                    | known
                )
                columns = ("error", "torque_error", "energy_change", "limit_overshoot", "note")
                shown = [f"{column} {known[column]:.2e}" for column in columns[:-1] if column in known]
                shown.append(known.get("note", ""))
                print(f"{name} {parameters:22} {engine:20} 1/{hz:<5} {', '.join(shown)}; {median:.3g} ms a step", flush=True)
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        with open(arguments.out / "mujoco_joints.csv", "w", encoding="utf-8", newline="") as sink:
            writer = csv.DictWriter(sink, COLUMNS, restval="")
            writer.writeheader()
            writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

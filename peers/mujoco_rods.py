#!/usr/bin/env python3
"""MuJoCo on the scenes that minimal coordinates can do: `rods`, `chain`, `top`.

Writes rows with the columns of `peers ... --out DIR` to DIR/mujoco.csv, where `plumb chart --peers`
reads them too. Needs MuJoCo: `pip install mujoco`. What MuJoCo is for, contact, is soft in it and
is not compared here.

A step is MuJoCo's own, without substeps; its time is that of `mj_step`, which takes many steps a call,
divided by the steps.
"""

import argparse
import csv
import pathlib
import statistics
import sys
import time

import mujoco
import numpy as np

COLUMNS = """
run,scene,parameters,engine,version,precision,hz,substeps,iterations,threads,seconds,answer,error,unit,error_at_1_s,joint_separation,joint_separation_end,hinge_tilt,limit_overshoot,torque_error,sink,sink_end,drift,overlap,overlap_end,energy_change,energy_drift,ms_per_step,ms_low,ms_high,times_plumb,times_fastest_peer,note
""".strip().split(",")
REFERENCE = pathlib.Path(__file__).resolve().parent.parent / "assets" / "reference"
INTEGRATORS = {"RK4": "mujoco:rk4", "Euler": "mujoco:euler", "implicitfast": "mujoco:implicitfast"}
RATES = (60, 120, 240, 480, 1000, 2000, 5000)


def box_moments(mass, x, y, z):
    """Principal moments of a box of full sizes x, y, z, kg m²."""
    return [mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y)]


def link(name, at, center, mass, moments, inner):
    """A body on a ball joint at `at` of its parent, its centre of mass at `center` from there."""
    moments = " ".join(f"{moment:.17g}" for moment in moments)
    return (
        f'<body name="{name}" pos="{at} 0 0"><joint type="ball"/>'
        f'<inertial pos="{center} 0 0" mass="{mass}" diaginertia="{moments}"/>{inner}</body>'
    )


def pendulum(rods, thickness, ball):
    """`rods` rods 1 m long along +x, then a ball of radius 1 m and that mass if there is one."""
    inner = ""
    if ball:
        inner = link("end", 1, 1, ball, [0.4 * ball] * 3, '<site name="tracked" pos="1 0 0"/>')
    for rod in reversed(range(rods)):
        if not inner:
            inner = '<site name="tracked" pos="1 0 0"/>'
        inner = link(f"rod{rod}", min(rod, 1), 0.5, 1, box_moments(1, 1, thickness, thickness), inner)
    return inner


def top():
    """A free box 1 × 0.6 × 0.2 m of density 1000."""
    mass = 1000 * 1 * 0.6 * 0.2
    moments = " ".join(f"{moment:.17g}" for moment in box_moments(mass, 1, 0.6, 0.2))
    return (
        f'<body name="top"><freejoint/><inertial pos="0 0 0" mass="{mass}" diaginertia="{moments}"/>'
        '<site name="tracked"/></body>'
    )


def scenes(seconds):
    """Name, parameters, bodies, gravity, reference file, seconds."""
    yield "rods", "n=5", pendulum(5, 0.1, None), 10, "rods-5.csv", seconds
    for mass in (1, 100, 1000):
        yield "chain", f"r={mass}", pendulum(10, 0.2, mass), 10, f"chain-{mass}.csv", seconds
    yield "top", "", top(), 0, None, 10


def reference(file):
    """Time, s, to point, m, but for the start, which is the scene's own."""
    with open(REFERENCE / file, encoding="utf-8", newline="") as table:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(table)]
    return {row["t_s"]: np.array([row["x_m"], row["y_m"], row["z_m"]]) for row in rows if row["t_s"] > 0}


def model_of(bodies, gravity, integrator, hz, energy):
    """Energy is worked out in each step only where it is asked for."""
    energy = "enable" if energy else "disable"
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="0 {-gravity} 0" timestep="{1 / hz:.17g}"'
        f' integrator="{integrator}"><flag contact="disable" energy="{energy}"/></option>'
        f"<worldbody>{bodies}</worldbody></mujoco>"
    )


def start(model, name):
    data = mujoco.MjData(model)
    if name == "top":
        data.qvel[3:6] = (0.01, 10, 0)
    mujoco.mj_forward(model, data)
    return data


def run(model, data, file, seconds, hz):
    """Simulates; returns the seconds it took and the error at each time of the reference."""
    answer = reference(file) if file else {}
    times = [time for time in answer if time <= seconds] or [seconds]
    took, errors, taken = 0.0, {}, 0
    for instant in times:
        steps = round(instant * hz) - taken
        begin = time.perf_counter()
        mujoco.mj_step(model, data, steps)
        took += time.perf_counter() - begin
        taken += steps
        mujoco.mj_forward(model, data)
        if instant in answer:
            errors[instant] = float(np.linalg.norm(data.site("tracked").xpos - answer[instant]))
    return took, errors


def unstable(data):
    """Whether MuJoCo has given up and started again from the scene's start."""
    kinds = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
    return any(data.warning[kind].number for kind in kinds)


def measure(scene, integrator, hz, rounds):
    """What is known of a run, by column, and the ms per step of each round."""
    name, _, bodies, gravity, file, seconds = scene
    model = model_of(bodies, gravity, integrator, hz, energy=file is None)
    milliseconds = []
    for _ in range(rounds):
        data = start(model, name)
        energy = data.energy.sum()
        took, errors = run(model, data, file, seconds, hz)
        milliseconds.append(1e3 * took / round(seconds * hz))
    if unstable(data):
        return dict(note="unstable: MuJoCo starts again"), milliseconds
    if file is None:
        return dict(energy_change=(data.energy.sum() - energy) / energy), milliseconds
    answer = "tip of the last rod" if name == "rods" else "centre of the ball"
    known = dict(answer=answer, error=max(errors.values()), unit="m", joint_separation=0.0, joint_separation_end=0.0)
    return known | (dict(error_at_1_s=errors[1.0]) if 1.0 in errors else {}), milliseconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", metavar="DIR", type=pathlib.Path, help="also write DIR/mujoco.csv")
    parser.add_argument("--rounds", type=int, default=9, help="how often each run is timed")
    parser.add_argument("--seconds", type=float, default=2, help="time to simulate rods and chain, at most 2 s")
    arguments = parser.parse_args()
    # Said in the rows; MuJoCo would write a log file into the current folder.
    mujoco.set_mju_user_warning(lambda _: None)
    rows = []
    print(f"mujoco {mujoco.__version__}, f64, 1 thread")
    for scene in scenes(arguments.seconds):
        name, parameters, *_, seconds = scene
        for integrator, engine in INTEGRATORS.items():
            for hz in RATES:
                known, milliseconds = measure(scene, integrator, hz, arguments.rounds)
                median = statistics.median(milliseconds)
                rows.append(
                    dict(
                        run="precision", scene=name, parameters=parameters, engine=engine, version=mujoco.__version__,
                        precision="f64", hz=float(hz), substeps=1, iterations=1, threads=1, seconds=float(seconds),
                        ms_per_step=median, ms_low=min(milliseconds), ms_high=max(milliseconds),
                    )
                    | known
                )
                what = next(column for column in ("note", "error_at_1_s", "error", "energy_change") if column in known)
                shown = known[what] if what == "note" else f"{what} {known[what]:.2e}"
                print(f"{name} {parameters:8} {engine:20} 1/{hz:<5} {shown}; {median * hz:.3g} ms per second")
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        with open(arguments.out / "mujoco.csv", "w", encoding="utf-8", newline="") as sink:
            writer = csv.DictWriter(sink, COLUMNS, restval="")
            writer.writeheader()
            writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

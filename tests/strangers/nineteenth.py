"""Tables of motors and of platforms on legs, which were taken for cells and wrenches."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.strangers.rigs import Made, Rng, rows, write


def thrust_stand(to: Path, rng: Rng) -> Made:
    """A motor's table: the throttle in µs, thrust, torque, and the supply."""
    us = np.linspace(1000, 2000, 21)
    newton = 1e-5 * (us - 1000) ** 2 + rng.normal(0, 0.02, 21)
    names = "ESC signal (µs),Torque (N·m),Thrust (N),Voltage (V),Current (A),Motor Speed (RPM)"
    body = rows(us, 0.02 * newton, newton, 16 - 0.01 * newton, 1.5 * newton, 5 * us, form="%.4f")
    return Made([write(to / "motor.csv", [names, *body])], says="which loads were put on")


def thrust_in_grams(to: Path, rng: Rng) -> Made:
    """The same of another stand, in grams and without units of the supply."""
    duty = np.linspace(0, 100, 21)
    gram = 0.1 * duty**2 + rng.normal(0, 1, 21)
    body = rows(duty, gram, 0.015 * gram, 16 - 1e-4 * gram, 0.2 * gram, form="%.3f")
    names = "throttle,thrust_g,current,voltage,power"
    return Made([write(to / "prop.csv", [names, *body])], says="which loads were put on")


def motor_and_its_chamber(to: Path, rng: Rng) -> Made:
    """A rocket motor: thrust in newtons, and the pressure that makes it."""
    bar = np.array([0, 2, 9, 14, 15, 14, 13, 11, 6, 1, 0.0])
    body = rows(0.1 * np.arange(11), 4.1 * bar + rng.normal(0, 0.3, 11), bar, form="%.3f")
    names = "Time (s),Thrust (N),Pressure (bar)"
    return Made([write(to / "burn.csv", [names, *body])], says="no reading next to it")


def legs_of_a_platform(to: Path, rng: Rng) -> Made:
    """Forces along six legs of a platform: no wrench, and nothing says where the legs stand."""
    t = 0.01 * np.arange(200)
    names = ",".join(["time", *(f"leg_force_{i}" for i in range(1, 7))])
    body = rows(t, *rng.normal(0, 20, (6, 200)), form="%.4f")
    return Made([write(to / "platform.csv", [names, *body])], says="where the cells sit")


NINETEENTH = (thrust_stand, thrust_in_grams, motor_and_its_chamber, legs_of_a_platform)

"""Height of a standing wave between two viscous fluids at rest, of one kinematic viscosity and unbounded depth
(Prosperetti 1981, Phys. Fluids 24, 1217, eq. 20), over its height at the start; writes exact.csv."""

import numpy as np
from scipy.special import wofz

K, NU, G = 2 * np.pi, 0.005, 1.0
HEAVY, LIGHT = 1000.0, 1.0


def height(t):
    square = G * K * (HEAVY - LIGHT) / (HEAVY + LIGHT)
    beta = HEAVY * LIGHT / (HEAVY + LIGHT) ** 2
    s, rate = np.sqrt(NU), NU * K**2
    z = np.roots([1, -4 * beta * K * s, 2 * (1 - 6 * beta) * rate, 4 * (1 - 3 * beta) * rate**1.5,
                  (1 - 4 * beta) * rate**2 + square])
    # exp(z² t) erfc(z √t) = w(i z √t), with Faddeeva's function w
    slow = 4 * (1 - 4 * beta) * rate**2 / (8 * (1 - 4 * beta) * rate**2 + square)
    total = slow * wofz(1j * np.sqrt(rate * t)).real * np.exp(-rate * t) + 0j
    for i in range(4):
        others = np.prod([z[j] - z[i] for j in range(4) if j != i])
        total += z[i] / others * square / (z[i] ** 2 - rate) * np.exp(-rate * t) * wofz(1j * z[i] * np.sqrt(t))
    return total.real


if __name__ == "__main__":
    with open("exact.csv", "w") as file:
        file.write("# Prosperetti 1981, eq. 20, by exact.py: time, height of the crest over that at the start\nt,a\n")
        for t in np.arange(0, 8.0001, 0.05):
            file.write(f"{t:.2f},{height(max(t, 1e-12)):.9f}\n")

#!/usr/bin/env python3
"""Writes shared/model/op3_table.h and shared/model/data/op3*.urdf from the public figures in shared/model/data/*.csv.

Run from the repository root after changing a figure:  python3 tools/model/generate_op3.py
Torso, head and arms are lumped into one body, with the arms in the maker's walkready pose (action file, page 9).
"""
import csv
import math
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "shared" / "model" / "data"

LEG = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ank_pitch", "ank_roll"]
LEG_JOINTS = ["r_" + n for n in LEG] + ["l_" + n for n in LEG]
# Walkready arm angles [deg]; joints not named here are at zero.
WALKREADY_DEG = {"r_sho_pitch": 4.92, "l_sho_pitch": -5.01, "r_sho_roll": -45.62, "l_sho_roll": 45.35,
                 "r_el": 45.18, "l_el": -45.35}
# Limits [x pi rad] of the maker's kinematics class: (right lower, right upper); the left side is mirrored.
LIMITS_PI = {"hip_yaw": (-0.45, 0.45), "hip_roll": (-0.3, 0.3), "hip_pitch": (-0.4, 0.4), "knee": (-0.7, 0.1),
             "ank_pitch": (-0.45, 0.45), "ank_roll": (-0.45, 0.45), "sho_pitch": (-0.5, 0.5),
             "sho_roll": (-0.5, 0.3), "el": (-0.5, 0.5), "head_pan": (-0.5, 0.5), "head_tilt": (-0.5, 0.5)}
STALL_TORQUE, NO_LOAD_SPEED = 4.1, 4.82  # XM430-W350 at 12 V


def read(name):
    with open(DATA / name, newline="") as f:
        return list(csv.DictReader(f))


def matmul(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transpose(A):
    return [list(r) for r in zip(*A)]


def apply(A, v):
    return [sum(A[i][k] * v[k] for k in range(3)) for i in range(3)]


def rotation(axis, angle):
    """Rodrigues' formula for a unit axis."""
    x, y, z = axis
    c, s, t = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y], [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c]]


def parallel_axis(mass, d):
    """Inertia of a point mass at d about the origin."""
    d2 = sum(c * c for c in d)
    return [[mass * ((d2 if i == j else 0.0) - d[i] * d[j]) for j in range(3)] for i in range(3)]


class Link:
    def __init__(self, row):
        self.name = row["name"]
        self.mass = float(row["mass_kg"])
        self.com = [float(row[f"com_{a}_m"]) for a in "xyz"]
        i = {k: float(row[f"i{k}_kgm2"]) for k in ("xx", "xy", "xz", "yy", "yz", "zz")}
        self.inertia = [[i["xx"], i["xy"], i["xz"]], [i["xy"], i["yy"], i["yz"]], [i["xz"], i["yz"], i["zz"]]]


class Joint:
    def __init__(self, row):
        self.name, self.type = row["name"], row["type"]
        self.parent, self.child = row["parent_link"], row["child_link"]
        self.origin = [float(row[f"origin_{a}_m"]) for a in "xyz"]
        self.rpy = [float(row[f"{a}_rad"]) for a in ("roll", "pitch", "yaw")]
        self.axis = [float(row[f"axis_{a}"] or 0) for a in "xyz"]
        self.id = int(row["dynamixel_id"] or 0)

    def limits(self):
        side, _, rest = self.name.partition("_")
        key = rest if side in ("r", "l") else self.name
        lower, upper = LIMITS_PI[key]
        return (-upper * math.pi, -lower * math.pi) if side == "l" else (lower * math.pi, upper * math.pi)


def lump_upper_body(links, joints):
    """One body in body_link axes: torso, head and arms, arms in walkready. Cameras are massless."""
    leg_children = {j.child for j in joints if j.name in LEG_JOINTS}
    bodies = []

    def visit(link, R, p):
        bodies.append((links[link], R, p))
        for j in joints:
            if j.parent == link and j.child not in leg_children and j.type == "revolute":
                origin = [a + b for a, b in zip(p, apply(R, j.origin))]
                angle = math.radians(WALKREADY_DEG.get(j.name, 0.0))
                visit(j.child, matmul(R, rotation(j.axis, angle)), origin)

    visit("body_link", [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0])
    mass = sum(b.mass for b, _, _ in bodies)
    coms = [[a + c for a, c in zip(p, apply(R, b.com))] for b, R, p in bodies]
    com = [sum(b.mass * c[i] for (b, _, _), c in zip(bodies, coms)) / mass for i in range(3)]
    inertia = [[0.0] * 3 for _ in range(3)]
    for (b, R, _), c in zip(bodies, coms):
        turned = matmul(matmul(R, b.inertia), transpose(R))
        shifted = parallel_axis(b.mass, [c[i] - com[i] for i in range(3)])
        inertia = [[inertia[i][j] + turned[i][j] + shifted[i][j] for j in range(3)] for i in range(3)]
    lumped = Link.__new__(Link)
    lumped.name, lumped.mass, lumped.com, lumped.inertia = "body_link", mass, com, inertia
    return lumped


def number(x):
    return repr(round(x, 12) + 0.0)


def body_row(link):
    i = link.inertia
    six = [i[0][0], i[0][1], i[0][2], i[1][1], i[1][2], i[2][2]]
    return (f"    {{{number(link.mass)}, {{{', '.join(map(number, link.com))}}},\n"
            f"     {{{', '.join(map(number, six))}}}}},  // {link.name}")


def write_table(bodies, leg_joints):
    geometry = []
    for j in leg_joints:
        k = max(range(3), key=lambda a: abs(j.axis[a]))
        geometry.append(f"    {{{{{', '.join(map(number, j.origin))}}}, {k}, {int(j.axis[k]):+d}}},  // {j.name}")
    text = """// The controlled OP3: upper body lumped into the base (arms in walkready), twelve leg links.
// Written by tools/model/generate_op3.py from shared/model/data/op3-*.csv (ROBOTIS figures, see data/README.md).
// Do not edit: change the figures and run the generator.
#pragma once

namespace sanso::model {

/// Mass properties of one body in the axes of its link frame.
struct BodyInertia {
  double mass;        // kg
  double com[3];      // m, from the link origin
  double inertia[6];  // kg m^2 about the centre of mass: xx xy xz yy yz zz
};

/// Where a joint sits on its parent. No OP3 joint has a fixed rotation, and all axes are coordinate axes.
struct JointGeometry {
  double origin[3];  // m, joint origin (= child link origin) in parent axes
  int axis;          // 0 x, 1 y, 2 z
  int sign;          // +1 or -1: the joint turns about sign * axis
};

inline constexpr int kNumBodies = 13;  // 0 base, 1..6 right leg, 7..12 left leg: body j + 1 is moved by joint j

inline constexpr BodyInertia kOp3Bodies[kNumBodies] = {
%s
};

inline constexpr JointGeometry kOp3Joints[kNumBodies - 1] = {
%s
};

/// Sole corners in ankle-roll axes [m], the four-point approximation inside the sole's octagon (left foot; right: -y).
inline constexpr double kSoleFront = 0.0815, kSoleBack = -0.0335;
inline constexpr double kSoleOuter = 0.0515, kSoleInner = -0.0265;
inline constexpr double kSoleHeight = -0.0305;

}  // namespace sanso::model
""" % ("\n".join(body_row(b) for b in bodies), "\n".join(geometry))
    (ROOT / "shared" / "model" / "op3_table.h").write_text(text)


def urdf_link(link):
    i = link.inertia
    if link.mass == 0:
        return f'  <link name="{link.name}"/>\n'
    return (f'  <link name="{link.name}">\n    <inertial>\n'
            f'      <origin xyz="{" ".join(map(number, link.com))}" rpy="0 0 0"/>\n'
            f'      <mass value="{number(link.mass)}"/>\n'
            f'      <inertia ixx="{number(i[0][0])}" ixy="{number(i[0][1])}" ixz="{number(i[0][2])}"'
            f' iyy="{number(i[1][1])}" iyz="{number(i[1][2])}" izz="{number(i[2][2])}"/>\n'
            f'    </inertial>\n  </link>\n')


def urdf_joint(j):
    head = (f'  <joint name="{j.name}" type="{j.type}">\n    <parent link="{j.parent}"/>\n    <child link="{j.child}"/>\n'
            f'    <origin xyz="{" ".join(map(number, j.origin))}" rpy="{" ".join(map(number, j.rpy))}"/>\n')
    if j.type == "revolute":
        lower, upper = j.limits()
        head += (f'    <axis xyz="{" ".join(map(number, j.axis))}"/>\n'
                 f'    <limit lower="{number(lower)}" upper="{number(upper)}" effort="{STALL_TORQUE}"'
                 f' velocity="{NO_LOAD_SPEED}"/>\n')
    return head + "  </joint>\n"


def write_urdf(name, comment, links, joints):
    body = "".join(map(urdf_link, links)) + "".join(map(urdf_joint, joints))
    (DATA / name).write_text(f'<?xml version="1.0"?>\n<!-- {comment} Written by tools/model/generate_op3.py. -->\n'
                             f'<robot name="op3">\n{body}</robot>\n')


def main():
    rows = read("op3-links.csv")
    links = {r["name"]: Link(r) for r in rows}
    joints = [Joint(r) for r in read("op3-joints.csv")]
    by_name = {j.name: j for j in joints}
    leg_joints = [by_name[n] for n in LEG_JOINTS]
    bodies = [lump_upper_body(links, joints)] + [links[j.child] for j in leg_joints]
    write_table(bodies, leg_joints)
    write_urdf("op3.urdf", "ROBOTIS OP3, 12 leg joints; torso, head and arms are one body (arms in walkready).", bodies,
               leg_joints)
    write_urdf("op3_full.urdf", "ROBOTIS OP3, all 20 joints.", [links[r["name"]] for r in rows], joints)


if __name__ == "__main__":
    main()

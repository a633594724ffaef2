#!/usr/bin/env python3
"""Writes the files beside it with software that is not tribos: rosbags, pyarrow, h5py, and plain text.

All of them hold one motion of two turning joints and a slider; j1.csv, j2.csv and slider.csv hold it column by column, and the
tests compare every file with these, value by value.

    python3 -m venv venv && . venv/bin/activate && pip install numpy==2.4.6 rosbags==0.11.9 pyarrow==26.0.1 h5py==3.16.0
    python3 make.py
"""
import shutil
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
START_NS = 1_790_000_000_123_456_789
SAMPLES = 240

random = np.random.default_rng(7)
# 5 ms with jitter, in whole nanoseconds; the first stamp is the zero of time_s
stamps = np.arange(SAMPLES) * 5_000_000 + np.concatenate([[0], random.integers(-200_000, 200_000, SAMPLES - 1)])
time = stamps / 1e9
joints = {}
for k, name in enumerate(["j1", "j2", "slider"]):
    w = 5.0 + 2.0 * k
    position = 0.3 * np.sin(w * time) + 1e-5 * random.standard_normal(SAMPLES)
    velocity = 0.3 * w * np.cos(w * time) + 1e-4 * random.standard_normal(SAMPLES)
    effort = 0.8 * np.sign(velocity) + 0.1 * velocity + 1e-3 * random.standard_normal(SAMPLES)
    joints[name] = (position, velocity, effort)
# a force sensor of its own clock, 2 ms, a straight line in time: what is interpolated is known in closed form
wrench_stamps = 30_000_000 + np.arange(500) * 2_000_000
wrench_z = 2.0 + 3.0 * (wrench_stamps / 1e9)


def csv(name, columns):
    lines = [",".join(columns)] + [",".join(repr(float(v)) for v in row) for row in zip(*columns.values())]
    (HERE / name).write_text("\n".join(lines) + "\n")


def columns_of(name):
    position, velocity, force = joints[name]
    if name == "slider":
        return {"time_s": time, "position_m": position, "velocity_m_s": velocity, "force_n": force}
    return {"time_s": time, "position_rad": position, "velocity_rad_s": velocity, "torque_nm": force}


for name in joints:
    csv(f"{name}.csv", columns_of(name))

# ROS 2
store = get_typestore(Stores.ROS2_JAZZY)
types = store.types
Header, Stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
JointState, Wrench = types["sensor_msgs/msg/JointState"], types["geometry_msgs/msg/Wrench"]
WrenchStamped, Vector3 = types["geometry_msgs/msg/WrenchStamped"], types["geometry_msgs/msg/Vector3"]
String = types["std_msgs/msg/String"]


def header(ns, frame=""):
    at = START_NS + int(ns)
    return Header(stamp=Stamp(sec=at // 10**9, nanosec=at % 10**9), frame_id=frame)


def bag(name, plugin, names, compress=False, force=True):
    folder = HERE / name
    shutil.rmtree(folder, ignore_errors=True)
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if compress:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        states = writer.add_connection("/joint_states", JointState.__msgtype__, typestore=store)
        if force:
            ft = writer.add_connection("/ft", WrenchStamped.__msgtype__, typestore=store)
        chatter = writer.add_connection("/chatter", String.__msgtype__, typestore=store)
        messages = []
        for i in range(SAMPLES):
            row = [np.array([joints[n][k][i] for n in names]) for k in range(3)]
            message = JointState(header=header(stamps[i]), name=list(names), position=row[0], velocity=row[1], effort=row[2])
            messages.append((stamps[i] + 150_000, states, message))
        for i, at in enumerate(wrench_stamps if force else []):
            force = Vector3(x=0.0, y=float(i), z=float(wrench_z[i]))
            message = WrenchStamped(header=header(at, "tool0"), wrench=Wrench(force=force, torque=Vector3(x=0.0, y=0.0, z=0.5)))
            messages.append((at + 90_000, ft, message))
        messages.append((0, chatter, String(data="hello")))
        for at, connection, message in sorted(messages, key=lambda m: m[0]):
            data = store.serialize_cdr(message, message.__msgtype__)
            writer.write(connection, START_NS + int(at), data)


bag("arm_sqlite", StoragePlugin.SQLITE3, ["j1", "slider", "j2"])
bag("arm_mcap", StoragePlugin.MCAP, ["j1", "slider", "j2"], compress=True)
bag("one_joint", StoragePlugin.MCAP, ["j2"], force=False)

# Parquet: all joints in one table, named by prefix; the time as a timestamp
table = {"time_s": time}
for name in ["j1", "j2"]:
    for column, values in columns_of(name).items():
        if column != "time_s":
            table[f"{name}_{column}"] = values
table["sample"] = np.arange(SAMPLES, dtype=np.int32)
table = pa.table(table).replace_schema_metadata({"rig": "arm"})
pq.write_table(table, HERE / "arm_snappy.parquet", compression="snappy")
pq.write_table(table, HERE / "arm_zstd.parquet", compression="zstd", row_group_size=100, data_page_version="2.0")
j1 = {k: v for k, v in columns_of("j1").items() if k != "time_s"}
stamped = pa.table({"time": pa.array(START_NS + stamps, pa.timestamp("ns")), **j1})
pq.write_table(stamped, HERE / "stamped.parquet", compression="gzip")

# HDF5: a group a joint, deflated; units as attributes
with h5py.File(HERE / "arm.h5", "w") as f:
    f.attrs["rig"] = "arm"
    f.attrs["mass_kg"] = 1.5
    f["time_s"] = time
    for name in ["j1", "j2"]:
        for column, values in columns_of(name).items():
            if column != "time_s":
                f.create_dataset(f"{name}/{column}", data=values, chunks=(64,), compression="gzip", shuffle=True, fletcher32=True)
# HDF5 1.10: arrays of samples by joints, in degrees
with h5py.File(HERE / "degrees.h5", "w", libver="v110") as f:
    f.create_dataset("time", data=time * 1e3).attrs["units"] = "ms"
    for quantity, k, unit, scale in [("position", 0, "deg", 180 / np.pi), ("velocity", 1, "deg/s", 180 / np.pi), ("torque", 2, "mNm", 1e3)]:
        stacked = np.stack([joints["j1"][k], joints["j2"][k]], axis=1) * scale
        f.create_dataset(quantity, data=stacked, chunks=(50, 2), compression="gzip", maxshape=(None, 2)).attrs["units"] = unit

# MATLAB 7.3: HDF5 behind 512 bytes of text, arrays transposed
mat = HERE / "arm_v73.mat"
with h5py.File(mat, "w", userblock_size=512) as f:
    def variable(path, values, kind="double"):
        data = f.create_dataset(path, data=np.atleast_2d(values))
        data.attrs["MATLAB_class"] = np.bytes_(kind)
    variable("t", time)
    variable("q", np.stack([joints["j1"][0], joints["j2"][0]]))
    variable("tau", np.stack([joints["j1"][2], joints["j2"][2]]))
    variable("gear", np.array([[100.0]]))
    variable("note", np.array([[ord(c)] for c in "arm"], dtype=np.uint16), "char")
    f.create_group("rig").attrs["MATLAB_class"] = np.bytes_("struct")
    variable("rig/qd", np.stack([joints["j1"][1], joints["j2"][1]]))
with open(mat, "r+b") as f:
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Nov 23 08:00:00 2026 HDF5 schema 1.00 ."
    f.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")

# text
position, velocity, force = joints["slider"]


def comma(x):
    return repr(float(x)).replace(".", ",")


rows = [";".join(map(comma, r)) for r in zip(time * 1e3, position * 1e3, velocity, force)]
(HERE / "decimal_comma.txt").write_text("\n".join(["time;position;velocity;force", "ms;mm;m/s;N", *rows]) + "\n")
rows = ["  ".join(f"{v!r:>24}" for v in map(float, r)) for r in zip(time, *joints["j1"])]
(HERE / "spaces.txt").write_text("\n".join(["time  position  velocity  torque", "[s]   [rad]     [rad/s]   [N*m]", *rows]) + "\n")
rows = ["\t".join(repr(float(v)) for v in r) for r in zip(time, *joints["j1"], *joints["j2"])]
names = ["time_s"] + [f"{c}_{k}" for k in (1, 2) for c in ("position_rad", "velocity_rad_s", "torque_nm")]
(HERE / "tabs.txt").write_text("\n".join(["\t".join(names), *rows]) + "\n")

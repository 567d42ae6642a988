"""Reads a ROS 2 export with rosbags and with evo and compares poses with the CSV of the same motion.

    check_ros2.py FILE.mcap FILE.csv
"""

import csv
import pathlib
import sys
from collections import Counter, defaultdict

import numpy
from evo.tools import file_interface
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader as Rosbag2Reader

path, table = sys.argv[1:]
rows = defaultdict(dict)
with open(table) as text:
    for row in csv.DictReader(line for line in text if not line.startswith("#")):
        # No blanks in names of ROS.
        topic = "/estimate/" + row["body"].replace(" ", "_") + "/pose"
        numbers = [float(row[c]) for c in ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")]
        rows[topic][int(row["stamp_ns"])] = numpy.array(numbers)

counts = Counter()
worst = 0.0
seen = 0
with AnyReader([pathlib.Path(path)]) as reader:
    for connection, _, data in reader.messages():
        message = reader.deserialize(data, connection.msgtype)
        counts[connection.topic, connection.msgtype] += 1
        if connection.topic in rows:
            stamp = message.header.stamp
            expected = rows[connection.topic].get(stamp.sec * 1_000_000_000 + stamp.nanosec)
            if expected is None:
                continue
            at, turn = message.pose.position, message.pose.orientation
            found = numpy.array([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w])
            found[3:] *= numpy.sign(found[3:] @ expected[3:])
            worst = max(worst, abs(found - expected).max())
            seen += 1
    # RViz takes a description only from who keeps it, and looks for frames and joints on these topics.
    offered = {of.topic: [qos.durability.name for qos in of.ext.offered_qos_profiles] for of in reader.connections}
    if offered["/robot_description"] != ["TRANSIENT_LOCAL"] or offered["/tf"] != ["VOLATILE"]:
        sys.exit(f"offered: {offered}")
with Rosbag2Reader(path) as reader:
    for topic in rows:
        read = file_interface.read_bag_trajectory(reader, topic)
        if read.num_poses != counts[topic, "geometry_msgs/msg/PoseStamped"]:
            sys.exit(f"evo reads {read.num_poses} poses on {topic}")
print(f"rosbags, evo: {sum(counts.values())} messages on {len(counts)} topics, {seen} poses, at most {worst:.1e} off")
if seen < 20 * len(rows) or worst > 1e-12:
    sys.exit("poses differ")

"""Checks one MCAP file with one client: check_clients.py mcap|rerun|rosbags FILE.

`check_clients.py make-ros2 FILE FOLDER` writes the performance in it as ROS 2 would.
"""

import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def fail(text):
    sys.exit(f"FAILED: {text}")


def check_mcap(path):
    """The Python reader: every checksum, every protobuf, every JSON against its schema."""
    import jsonschema
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    counts = collections.Counter()
    last = 0
    with open(path, "rb") as file:
        reader = make_reader(
            file, decoder_factories=[DecoderFactory()], validate_crcs=True
        )
        summary = reader.get_summary()
        # In the order of the file: a file that is not sorted is seen.
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if message.log_time < last:
                fail(f"{channel.topic}: log time {message.log_time} after {last}")
            last = message.log_time
            counts[channel.topic] += 1
            if channel.message_encoding == "json" and schema.encoding == "jsonschema":
                definition = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(definition)
                jsonschema.validate(json.loads(message.data), definition)
    decoded = 0
    with open(path, "rb") as file:
        reader = make_reader(
            file, decoder_factories=[DecoderFactory()], validate_crcs=True
        )
        protobuf = {
            c.topic for c in summary.channels.values() if c.message_encoding == "protobuf"
        }
        for schema, channel, message, content in reader.iter_decoded_messages(
            topics=sorted(protobuf)
        ):
            if content.DESCRIPTOR.full_name != schema.name:
                fail(f"{channel.topic}: {content.DESCRIPTOR.full_name}, not {schema.name}")
            if channel.topic == "/scene":
                check_scene(content, any(topic.startswith("/sketch/") for topic in counts))
            decoded += 1
        attachments = [a.name for a in reader.iter_attachments()]
    if sum(counts.values()) != summary.statistics.message_count:
        fail(f"{sum(counts.values())} messages, {summary.statistics.message_count} claimed")
    for topic in sorted(counts):
        print(f"mcap      {counts[topic]:6d} {topic}")
    print(f"mcap      {decoded} protobuf messages decoded, attachments {attachments}")


def check_scene(update, has_sketch):
    """What is drawn: bodies, ways as lines, events with names, and where poses were seen, ghosts that are seen through."""
    kinds = collections.Counter(entity.id.split("/")[0] for entity in update.entities)
    seen = ("sketch", "acted way") if has_sketch else ()
    for kind in ("body", "way", "event", *seen):
        if not kinds[kind]:
            fail(f"/scene: no {kind}")
    for entity in update.entities:
        shapes = [*entity.cubes, *entity.spheres, *entity.cylinders, *entity.triangles]
        kind = entity.id.split("/")[0]
        if kind == "sketch" and not all(0 < shape.color.a < 1 for shape in shapes):
            fail(f"/scene: {entity.id} is not seen through")
        if kind.endswith("way") and not all(len(line.points) > 1 for line in entity.lines):
            fail(f"/scene: {entity.id} leads nowhere")
    print(f"mcap      /scene: {dict(kinds)}")


def run(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    output = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
    if done.returncode != 0:
        fail(f"{' '.join(command)}: {output}")
    return output


def without_spaces(output):
    """Without what Rerun says of names with spaces, which it escapes: "rod 1" is a name of a body."""
    lines = output.splitlines()
    return "\n".join(line for line in lines if "Unescaped whitespace" not in line)


def check_rerun(path):
    """Rerun: its full check, conversion, verification, and that transforms are drawn."""
    rerun = str(pathlib.Path(sys.executable).with_name("rerun"))
    output = run(rerun, "mcap", "check", "--full", path)
    for line in output.strip().splitlines():
        print(f"rerun     check: {line}")
    if re.search(r"\b(error|warn(ing)?|invalid)\b", without_spaces(output), re.I):
        fail("rerun mcap check complains")
    with tempfile.TemporaryDirectory() as directory:
        converted = os.path.join(directory, "out.rrd")
        output = run(
            rerun, "mcap", "convert", "--application-id", "enact", path, "-o", converted
        )
        for line in output.strip().splitlines():
            print(f"rerun     convert: {line}")
        if re.search(r"\b(error|warn(ing)?)\b", without_spaces(output), re.I):
            fail("rerun mcap convert complains")
        output = run(rerun, "rrd", "verify", converted)
        for line in output.strip().splitlines():
            print(f"rerun     verify: {line}")
        printed = run(rerun, "rrd", "print", "-v", converted)
        for what in ("Transform3D:translation", "Boxes3D", "Cylinders3D"):
            print(f"rerun     {what}: {printed.count(what)}")
        if "Transform3D:translation" not in printed:
            fail("rerun draws no transforms")
        # Rerun shows every ROS 2 string as text and finds URDF in those alone: docs/report.md says how to
        # have the bodies without the text.
        decoders = [part for name in ("foxglove", "urdf", "recording_info") for part in ("-d", name)]
        run(rerun, "mcap", "convert", "--application-id", "enact", *decoders, path, "-o", converted)
        printed = run(rerun, "rrd", "print", "-v", converted)
        if "TextDocument" in printed or "visual_geometries" not in printed:
            fail("rerun draws URDF as text, or no bodies, where it should not")
        print("rerun     bodies without text")


def check_rosbags(path):
    """rosbags reads the ROS 2 profile only: it reads all of that, and of others it must say so."""
    from mcap.reader import make_reader
    from rosbags.highlevel import AnyReader, AnyReaderError

    with open(path, "rb") as file:
        reader = make_reader(file)
        is_ros2 = reader.get_header().profile == "ros2"
        expected = collections.Counter(
            channel.topic for _, channel, _ in reader.iter_messages()
        )
    try:
        with AnyReader([pathlib.Path(path)]) as reader:
            counts = collections.Counter()
            for connection, _, data in reader.messages():
                reader.deserialize(data, connection.msgtype)
                counts[connection.topic] += 1
    except AnyReaderError as error:
        if is_ros2 or "ros2" not in str(error).lower():
            fail(f"rosbags: {error}")
        print(f"rosbags   does not apply: {error}")
        return
    if counts != expected:
        fail(f"rosbags reads {dict(counts)}, there are {dict(expected)}")
    for topic in sorted(counts):
        print(f"rosbags   {counts[topic]:6d} {topic}")


def make_ros2(source, folder):
    """Writes a performance as a ROS 2 recorder would: tracker poses, marks as headers."""
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    time_type, header_type = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    pose_type, point_type = types["geometry_msgs/msg/Pose"], types["geometry_msgs/msg/Point"]
    stamped, turn = "geometry_msgs/msg/PoseStamped", types["geometry_msgs/msg/Quaternion"]

    def header(stamp, frame):
        return header_type(stamp=time_type(sec=stamp.seconds, nanosec=stamp.nanos), frame_id=frame)

    with open(source, "rb") as file, Writer(
        pathlib.Path(folder), version=9, storage_plugin=StoragePlugin.MCAP
    ) as writer:
        connections = {}
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        topics = [
            channel.topic
            for channel in reader.get_summary().channels.values()
            if channel.topic.startswith("/tracker/") or channel.topic == "/marks"
        ]
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=topics):
            kind = "std_msgs/msg/Header" if channel.topic == "/marks" else stamped
            if channel.topic not in connections:
                connections[channel.topic] = writer.add_connection(
                    channel.topic, kind, typestore=store
                )
            if channel.topic == "/marks":
                names = [pair.value for pair in decoded.metadata if pair.key == "event"]
                made = header(decoded.start_time, names[0] if names else "")
            else:
                p, q = decoded.pose.position, decoded.pose.orientation
                made = types[stamped](
                    header=header(decoded.timestamp, decoded.frame_id),
                    pose=pose_type(
                        position=point_type(x=p.x, y=p.y, z=p.z),
                        orientation=turn(x=q.x, y=q.y, z=q.z, w=q.w),
                    ),
                )
            data = store.serialize_cdr(made, kind)
            writer.write(connections[channel.topic], message.log_time, data)
    print(f"rosbags   {sum(1 for _ in connections)} topics written")


if __name__ == "__main__":
    {
        "mcap": check_mcap,
        "rerun": check_rerun,
        "rosbags": check_rosbags,
        "make-ros2": make_ros2,
    }[sys.argv[1]](*sys.argv[2:])

"""Reads a journal with clients that are not ours, and fails if they complain.

    python check_journal.py TAKE.mcap

Every chunk passes its checksum, log times are in order, the counts obey their schema, and the
pose of every used sample is bit for bit the one of the raw sample before it.
"""
import json, sys
import jsonschema
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2

def reader(path):
    return make_reader(open(path, "rb"), decoder_factories=[Protobuf(), Ros2()], validate_crcs=True)

def main(path):
    last, topics = 0, set()
    for schema, channel, message in reader(path).iter_messages(log_time_order=False):
        assert message.log_time >= last, channel.topic
        last = message.log_time
        if channel.message_encoding == "json":
            jsonschema.validate(json.loads(message.data), json.loads(schema.data))
        else:
            topics.add(channel.topic)
    raw, used, marks = {}, 0, 0
    for schema, channel, _, decoded in reader(path).iter_decoded_messages(topics=topics):
        if schema.name == "enact_msgs/msg/RawPose":
            raw[channel.topic.removeprefix("/capture")] = decoded
        elif schema.name == "enact_msgs/msg/RawMark":
            marks += 1
        elif schema.name == "foxglove.PoseInFrame":
            sample, pose = raw[channel.topic], decoded.pose
            assert list(sample.position_m) == [pose.position.x, pose.position.y, pose.position.z]
            q = pose.orientation
            assert list(sample.quaternion_xyzw) == [q.x, q.y, q.z, q.w]
            used += 1
    assert used > 0
    print(f"{path}: {used} samples used, {marks} marks")

if __name__ == "__main__":
    main(sys.argv[1])
